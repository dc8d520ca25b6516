#!/usr/bin/env python3
"""Checks that two builds of the program give the same results.

    compare_results.py make PROGRAM OUT [--jobs-only NAME...]
        Runs the jobs below with PROGRAM (a path to `orient`), each afresh in OUT/NAME. Nothing in
        them is random. Five minutes on two cores. Jobs on real data read it from
        $ORIENT_SHARED_DATA (default: ../shared/data beside the project) and are skipped without it.
    compare_results.py compare OUT_A OUT_B [--tolerance 1e-9] [--messages] [--jobs-only NAME...]
        A is the reference. The exit code is 1 if a number, a state or an exit code differs in B, or
        if a file or a field of A is missing in B. Additions in B are noted. Messages, digests of
        inputs, pages and pictures may differ; they are counted, and listed with --messages.
    compare_results.py --self-test
        Checks that a changed pose, a changed state, a missing file ... are found.

Numbers agree if they differ by no more than the tolerance times their size, where numbers below 1
count as 1 and those above 1000 (coordinates) as 1000. Elements of covariances are compared relative
to their standard deviations, sigmas and lens parameters relative to their own size. Not compared
are the folders `stages` (internal, for --resume), times of day, and the folders in paths.

    demo     three simulated photos of scanned film, as in ./demo; the patch database learns
    strips   six photos in two strips, old film and orthophoto: block with GNSS, self-calibration,
             held-out patches, all exports, resampled images, exports read back; a block with two
             photos without approximate positions
    reseau   deformed film with 121 crosses: interior, exterior
    film     six real scanned frames, one of them also with --camera auto
    ngi      four real frames: a block from patches of two orthophotos; single photos from patches
             of the other strip's photos, and from 2 km off with unknown kappa
    world    single photos on film from another simulator: three with a doubtful principal distance,
             one with unknown kappa
"""

import argparse
import json
import os
import pathlib
import shutil
import sqlite3
import struct
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # beside the sources
from result_comparison import Comparison  # noqa: E402
from result_jobs import (COMMANDS, CONSOLE, JOBS, PROJECT, Job, JobFailed,  # noqa: E402
                         shared_data)

RECORD = "made.json"  # in OUT: which jobs were done, and where


def done_job(name, program, folder, data):
    """Runs a job; returns its outcome."""
    shutil.rmtree(folder, ignore_errors=True)
    work, needs = JOBS[name]
    absent = [need for need in needs if not (data / need).is_dir()]
    if absent:
        return f"skipped: no {', '.join(absent)} in {data}"
    folder.mkdir(parents=True)
    try:
        work(Job(program, folder, data))
    except JobFailed as failure:
        return f"failed: {failure}"
    return "done"


def make(program, out, names):
    program, out, data = pathlib.Path(program).resolve(), pathlib.Path(out).resolve(), shared_data()
    if not program.is_file():
        sys.exit(f"{program}: no such program")
    jobs = {}
    if (out / RECORD).exists():
        jobs = json.loads((out / RECORD).read_text(encoding="utf-8"))["jobs"]
    elif out.exists() and any(out.iterdir()):
        sys.exit(f"{out}: holds something else; name another folder")
    out.mkdir(parents=True, exist_ok=True)
    record = {"out": str(out), "data": str(data), "project": str(PROJECT), "jobs": jobs}
    start = time.monotonic()
    for name in names:
        begin = time.monotonic()
        for said in ("unfinished", None):
            jobs[name] = said or done_job(name, program, out / name, data)
            (out / RECORD).write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        print(f"{name:8} {time.monotonic() - begin:6.1f} s  {jobs[name]}", flush=True)
    print(f"all      {time.monotonic() - start:6.1f} s")
    return 1 if any(jobs[name].startswith("failed") for name in names) else 0


def files_of(job):
    return {path.relative_to(job).as_posix(): path for path in sorted(job.rglob("*"))
            if path.is_file() and "stages" not in path.relative_to(job).parts
            and not path.name.endswith(("-wal", "-shm"))}


def compare(out_a, out_b, tolerance, names):
    """Compares all jobs of A, or those named."""
    outs = [pathlib.Path(out) for out in (out_a, out_b)]
    for out in outs:
        if not (out / RECORD).exists():
            sys.exit(f"{out}: not made by 'compare_results.py make'")
    records = [json.loads((out / RECORD).read_text(encoding="utf-8")) for out in outs]
    roots = [[(record[key], f"<{key}>") for key in ("out", "data", "project")]
             for record in records]
    comparison = Comparison(tolerance, roots)
    for name in names or records[0]["jobs"]:
        done = [record["jobs"].get(name, "not run") for record in records]
        comparison.file = name
        if done != ["done", "done"]:
            both_skipped = all(state.startswith("skipped") for state in done)
            comparison.add(comparison.notes if both_skipped else comparison.differences,
                           f"the job: {done[0]} -> {done[1]}")
            continue
        a, b = (files_of(out / name) for out in outs)
        for file in sorted(a.keys() | b.keys()):
            comparison.file = f"{name}/{file}"
            if file not in b:
                comparison.add(comparison.differences, "the file is not there any more")
            elif file not in a:
                comparison.add(comparison.notes, "a new file")
            else:
                comparison.compare(f"{name}/{file}", a[file], b[file])
    return comparison


def made_up(out):
    """A folder as left by `make`, with one file of each kind."""
    job = out / "demo"
    (job / "stages").mkdir(parents=True)
    result = {"photo": "a", "status": "ok", "pose": {"x": 1.5, "y": 3.7e6, "omega": -0.25},
              "covariance": [[4e-2, 1e-7], [1e-7, 1e-10]], "sigma0_px": 0.09,
              "patches": [{"id": 1, "state": "matched", "pixel": [10.5, 20.25], "reason": ""}],
              "not_visible": {"outside the frame": 2}, "alone": None,
              "made_from": "0123456789abcdef", "camera": f"{out}/demo/camera.toml",
              "messages": [f"see {out}"]}
    texts = {"../" + RECORD: json.dumps({"out": str(out), "data": "/d", "project": "/p",
                                         "jobs": {"demo": "done", "film": "skipped: no film"}}),
             "a.exterior.json": json.dumps(result), "stages/ties.json": "{}",
             COMMANDS: json.dumps([{"command": ["block"], "exit_code": 0}]),
             "pose_covariance.csv": "filename,element,a.x,a.phi\na,x,4,1e-4\na,phi,1e-4,1e-8\n",
             CONSOLE: f"$ orient block\nblock  1 of 3, 33 %, 2 s left\nreport  {out}/report.html\n",
             "orientation.csv": "filename,x,sigma_x\na,1.5,0.00002\n",
             "camera.toml": "# one\n[distortion]\nk = [-2.5e-9]\nearth_k1 = -2.5e-9\n",
             "cameras.txt": "# images\n1 PINHOLE 0.5 -7.25e-3\n"}
    for name, text in texts.items():
        (job / name).write_text(text, encoding="utf-8")
    database = sqlite3.connect(job / "block.gpkg")
    database.execute("CREATE TABLE photos (id INTEGER, geom BLOB, status TEXT, created TEXT)")
    point = b"GP\0\x01" + struct.pack("<i", 4326) + struct.pack("<BI3d", 1, 1001, 1.0, 2.0, 3.0)
    database.execute("INSERT INTO photos VALUES (1, ?, 'ok', '2020')", (point,))
    database.commit()
    database.close()


def edited(name, old, new):
    def edit(job):
        text = (job / name).read_text(encoding="utf-8")
        assert old in text, (name, old)
        (job / name).write_text(text.replace(old, new), encoding="utf-8")
    return edit


def by_sql(statement, *values):
    def edit(job):
        database = sqlite3.connect(job / "block.gpkg")
        database.execute(statement, values)
        database.commit()
        database.close()
    return edit


def moved_point(by):
    return b"GP\0\x01" + struct.pack("<i", 4326) + struct.pack("<BI3d", 1, 1001, 1.0 + by, 2.0, 3.0)


PHOTO = "a.exterior.json"
# what is changed: (how, expected differences, notes, messages)
CASES = {
    "nothing": (lambda job: None, 0, 0, 0),
    "a pose": (edited(PHOTO, '"x": 1.5', '"x": 1.50000001'), 1, 0, 0),
    "a large coordinate": (edited(PHOTO, "3700000.0", "3700000.00001"), 1, 0, 0),
    "a pose within the tolerance": (edited(PHOTO, '"x": 1.5', '"x": 1.5000000001'), 0, 0, 0),
    "a pose that is gone": (edited(PHOTO, '{"x": 1.5, "y": 3700000.0, "omega": -0.25}', "null"),
                            1, 0, 0),
    "a small covariance": (edited(PHOTO, "1e-10", "1.001e-10"), 1, 0, 0),
    "a covariance of all poses": (edited("pose_covariance.csv", "1e-8", "1.001e-8"), 1, 0, 0),
    "a sigma": (edited("orientation.csv", "0.00002", "0.0000200001"), 1, 0, 0),
    "a status": (edited(PHOTO, '"ok"', '"weak"'), 1, 0, 0),
    "a patch's state": (edited(PHOTO, "matched", "rejected"), 1, 0, 0),
    "a patch more": (edited(PHOTO, '"patches": [', '"patches": [{}, '), 1, 0, 0),
    "an exit code": (edited(COMMANDS, '"exit_code": 0', '"exit_code": 3'), 1, 0, 0),
    "a message": (edited(PHOTO, "see ", "look at "), 0, 0, 1),
    "what the program says": (edited(CONSOLE, "report", "page"), 0, 0, 1),
    "progress": (edited(CONSOLE, "2 s", "3 s"), 0, 0, 0),
    "a reason": (edited(PHOTO, '"reason": ""', '"reason": "dark"'), 0, 0, 1),
    "a reason's words in counts": (edited(PHOTO, "outside the", "beyond the"), 0, 0, 1),
    "a digest": (edited(PHOTO, "0123456789abcdef", "1123456789abcdef"), 0, 0, 1),
    "a new field": (edited(PHOTO, '"photo"', '"film": 1, "photo"'), 0, 1, 0),
    "a field that vanished": (edited(PHOTO, '"sigma0_px": 0.09, ', ""), 1, 0, 0),
    "a missing file": (lambda job: (job / PHOTO).unlink(), 1, 0, 0),
    "a new file": (lambda job: (job / "b.json").write_text("{}", encoding="utf-8"), 0, 1, 0),
    "an internal file": (lambda job: (job / "stages/ties.json").unlink(), 0, 0, 0),
    "a row of a table": (edited("orientation.csv", "\na,1.5", "\na,1.6"), 1, 0, 0),
    "a lens parameter": (edited("camera.toml", "[-2.5e-9]", "[-2.6e-9]"), 1, 0, 0),
    "the earth in a lens": (edited("camera.toml", "k1 = -2.5e-9", "k1 = -2.6e-9"), 1, 0, 0),
    "a comment": (edited("camera.toml", "# one", "# two"), 0, 0, 1),
    "a number of an export": (edited("cameras.txt", "-7.25e-3", "-7.26e-3"), 1, 0, 0),
    "a word of an export": (edited("cameras.txt", "PINHOLE", "OPENCV"), 1, 0, 0),
    "a geometry": (by_sql("UPDATE photos SET geom = ?", moved_point(1e-6)), 1, 0, 0),
    "a geometry within the tolerance": (by_sql("UPDATE photos SET geom = ?", moved_point(1e-12)),
                                        0, 0, 0),
    "a row of a GeoPackage": (by_sql("UPDATE photos SET status = 'weak'"), 1, 0, 0),
    "a time": (by_sql("UPDATE photos SET created = '2021'"), 0, 0, 0),
    "a job": (edited("../" + RECORD, '"demo": "done"', '"demo": "skipped: no demo"'), 1, 0, 0),
}


def self_test():
    wrong = []
    for name, (edit, *expected) in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            outs = [pathlib.Path(folder) / side for side in ("a", "elsewhere")]
            for out in outs:
                made_up(out)
            edit(outs[1] / "demo")
            found = compare(*outs, 1e-9, None)
            kinds = (found.differences, found.notes, found.messages)
            counts = [sum(map(len, kind.values())) for kind in kinds]
            expected[1] += 1  # the job skipped in both
            if counts != expected:
                wrong.append(f"{name}: differences, notes, messages {counts}, not {expected}")
    print("\n".join(wrong) or f"{len(CASES)} changes are judged as they should be")
    return 1 if wrong else 0


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest="mode", required=True)
    making = modes.add_parser("make")
    making.add_argument("program")
    making.add_argument("out")
    comparing = modes.add_parser("compare")
    comparing.add_argument("out_a")
    comparing.add_argument("out_b")
    comparing.add_argument("--tolerance", type=float, default=1e-9)
    comparing.add_argument("--messages", action="store_true")
    for mode in (making, comparing):
        mode.add_argument("--jobs-only", nargs="+", choices=JOBS, metavar="NAME")
    told = parser.parse_args(arguments)
    if told.mode == "make":
        return make(told.program, told.out, told.jobs_only or JOBS)
    found = compare(told.out_a, told.out_b, told.tolerance, told.jobs_only)
    found.report(told.messages)
    return 1 if found.differences else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
