#!/usr/bin/env python3
"""Feeds every reader of tests/fuzz with inputs from libFuzzer, and keeps those with new coverage.

    run.py SECONDS [READER ...]     CPU time for each reader; builds what it needs (Clang 14)
    run.py --keep [READER ...]      stores the fewest inputs of equal coverage in corpus/READER.zip

Starts from the inputs of corpus/ and of earlier runs, and from the string literals in the reader's
sources. New inputs go to build/fuzz/inputs/READER, findings (a crash, more than 1 GB of memory,
more than 10 s) to build/fuzz/findings; each can be reproduced by

    build/fuzz/tests/fuzz/fuzz_corpus FILE READER

Prints for each reader the number of executions, of program edges covered at the beginning and at
the end (`edges`), of edges distinguished by their hit counts (`features`), of inputs, and the peak
memory. The exit code is 1 if anything was found.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
CORPUS, BUILD = ROOT / "tests/fuzz/corpus", ROOT / "build/fuzz"
FUZZER = BUILD / "tests/fuzz/orient_fuzz"
LIMITS = ["-rss_limit_mb=1024", "-timeout=10", "-max_len=20000"]
# Sources with the keywords of a format: they give valid inputs sooner than random bytes.
WORDS = {"camera_file": ["core/files/camera_file*.cpp", "core/files/mark_elements_toml.cpp"],
         "block_file": ["core/files/block_file.cpp", "core/files/flight_plan_keys.cpp"],
         "orientation_table": ["core/files/orientation_table.cpp"],
         "flight_index": ["block/inputs/approximations.cpp"],
         "control_table": ["tools/commands/patchdb/control_table.cpp"],
         "interior_result": ["core/files/interior_result.cpp", "core/files/result*.cpp"],
         "exterior_result": ["core/files/exterior_result.cpp", "core/files/result*.cpp"],
         "region_index": ["patchdb/regions/region_index.cpp"],
         "block_result": ["core/files/adjustment_result.cpp", "core/files/result*.cpp"],
         "stage_file": ["block/ties/tie_file.cpp", "block/stages/keypoint_file.cpp"],
         "export_record": ["tools/convert/export_record.cpp"],
         "micmac": ["core/exchange/micmac_orientation.cpp"],
         "metashape": ["core/exchange/metashape.cpp"],
         "colmap": ["core/exchange/colmap.cpp"],
         "opensfm": ["core/exchange/opensfm.cpp"],
         "asp": ["core/exchange/asp_pinhole.cpp"],
         "ori": ["core/exchange/frame_adjustments.cpp"],
         "patb": ["core/exchange/frame_adjustments.cpp"],
         "bingo": ["core/exchange/frame_adjustments.cpp"],
         "png": ["core/raster/png_bands.cpp"],
         "dem": ["core/terrain/dem_raster.cpp"]}
LITERAL = re.compile(r'"((?:[^"\\\n]|\\.){1,40})"')
DEM = ["ncols ", "nrows ", "xllcorner ", "yllcorner ", "cellsize ", "NODATA_value ", "dx ", "dy "]
NUMBERS = ["1e308", "-1e308", "1e-308", "nan", "inf", "-0", "2147483647", "-2147483648", "4294967296",
           "9223372036854775807", "0.5"]


def environment(reader, scratch):
    leaks = ROOT / "tests/support/leaks.supp"
    return {**os.environ, "ORIENT_READER": reader, "TMPDIR": scratch,
            "ASAN_OPTIONS": "quarantine_size_mb=16:detect_stack_use_after_return=0",
            "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
            "LSAN_OPTIONS": f"suppressions={leaks}:print_suppressions=0"}


def write_dictionary(reader, path):
    words = set(NUMBERS) | ({*DEM} if reader == "dem" else set())
    for pattern in WORDS.get(reader, []):
        for source in ROOT.glob(pattern):
            words |= set(LITERAL.findall(source.read_text(encoding="utf-8")))
    # libFuzzer's escapes are \\\\, \\" and \\xAB.
    sound = [word for word in sorted(words) if not re.search(r"\\[^\\\"x]|[^ -~]", word)]
    path.write_text("".join(f'"{word}"\n' for word in sound), encoding="utf-8")


def kept_inputs(reader, folder):
    """Writes all inputs of corpus/ as files to a folder."""
    for path in (CORPUS / reader).iterdir() if (CORPUS / reader).is_dir() else []:
        (folder / path.name).write_bytes(path.read_bytes())
    archive = CORPUS / f"{reader}.zip"
    if archive.exists():
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)


def scratch_folder():
    """In memory if possible: readers need files."""
    memory = pathlib.Path("/dev/shm")
    return tempfile.TemporaryDirectory(dir=memory if os.access(memory, os.W_OK) else None)


def fuzz(reader, seconds):
    """Fuzzes a reader; returns the figures of its run."""
    own = BUILD / "inputs" / reader
    findings = BUILD / "findings" / reader
    for folder in (own, findings):
        folder.mkdir(parents=True, exist_ok=True)
    shown = {"executions": 0, "start": None, "edges": 0, "features": 0, "inputs": 0, "memory": 0,
             "seconds": 0.0, "found": False}
    with scratch_folder() as scratch:
        kept = pathlib.Path(scratch) / "kept"
        kept.mkdir()
        kept_inputs(reader, kept)
        words = pathlib.Path(scratch) / "words"
        write_dictionary(reader, words)
        while shown["seconds"] < seconds and not shown["found"]:
            left = max(1, round(seconds - shown["seconds"]))
            line = [FUZZER, own, kept, *LIMITS, f"-max_total_time={left}", f"-dict={words}",
                    f"-artifact_prefix={findings}/", "-print_final_stats=1", "-reload=0"]
            log = BUILD / f"inputs/{reader}.log"
            with open(log, "w", encoding="utf-8") as file:
                process = subprocess.Popen(line, stdout=file, stderr=file,
                                           env=environment(reader, scratch), cwd=scratch)
                _, status, used = os.wait4(process.pid, 0)
                process.returncode = os.waitstatus_to_exitcode(status)
            take_log(log.read_text(encoding="utf-8", errors="replace"), shown)
            shown["seconds"] += used.ru_utime + used.ru_stime
            shown["found"] = process.returncode != 0
    return shown


def take_log(text, shown):
    progress = re.findall(r"^#(\d+)\s+(\w+)\s+cov: (\d+) ft: (\d+) corp: (\d+)/", text, re.MULTILINE)
    if progress:
        inited = next((edges for _, event, edges, _, _ in progress if event == "INITED"), None)
        if shown["start"] is None and inited:
            shown["start"] = int(inited)
        executions, _, edges, features, inputs = progress[-1]
        shown["edges"], shown["features"], shown["inputs"] = int(edges), int(features), int(inputs)
        shown["executions"] += int(executions)
    for peak in re.findall(r"stat::peak_rss_mb:\s+(\d+)", text):
        shown["memory"] = max(shown["memory"], int(peak))


def keep(reader):
    """Keeps the fewest and smallest inputs that have the coverage of all of them."""
    with scratch_folder() as scratch:
        kept, fewest = pathlib.Path(scratch) / "kept", pathlib.Path(scratch) / "fewest"
        kept.mkdir()
        fewest.mkdir()
        kept_inputs(reader, kept)
        subprocess.run([FUZZER, fewest, kept, BUILD / "inputs" / reader, *LIMITS, "-merge=1"],
                       env=environment(reader, scratch), cwd=scratch, check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with zipfile.ZipFile(CORPUS / f"{reader}.zip", "w", zipfile.ZIP_DEFLATED, True, 9) as packed:
            for path in sorted(fewest.iterdir()):
                # Without a time, so that the same inputs give the same archive.
                packed.writestr(zipfile.ZipInfo(path.name), path.read_bytes(), zipfile.ZIP_DEFLATED)
    print(f"{reader}: {len(list(zipfile.ZipFile(CORPUS / f'{reader}.zip').namelist()))} inputs, "
          f"{(CORPUS / f'{reader}.zip').stat().st_size} bytes")


def build():
    for line in (["cmake", "--preset", "fuzz"],
                 ["cmake", "--build", BUILD, "--target", "orient_fuzz", "fuzz_corpus"]):
        subprocess.run(line, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    done = subprocess.run([BUILD / "tests/fuzz/fuzz_corpus", "--list"], check=True, text=True,
                          capture_output=True)
    return done.stdout.split()


def main(words):
    if not words:
        sys.exit(__doc__)
    readers = build()
    chosen = words[1:] or readers
    if words[0] == "--keep":
        for reader in chosen:
            keep(reader)
        return 0
    found = []
    print(f"{'reader':18} {'executions':>10} {'edges':>13} {'features':>8} {'inputs':>6} {'MB':>5} "
          f"{'CPU s':>6}")
    for reader in chosen:
        shown = fuzz(reader, float(words[0]))
        print(f"{reader:18} {shown['executions']:10} {shown['start'] or 0:5} > {shown['edges']:5} "
              f"{shown['features']:8} {shown['inputs']:6} {shown['memory']:5} {shown['seconds']:6.0f}"
              + ("  FOUND" if shown["found"] else ""), flush=True)
        found += [reader] if shown["found"] else []
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
