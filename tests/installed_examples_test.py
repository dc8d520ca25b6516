#!/usr/bin/env python3
"""CTest `installed_examples`: programs can be built on the installed libraries.

    installed_examples_test.py BUILD EXAMPLES

Installs the build tree BUILD under a temporary prefix, builds the EXAMPLES against it alone, and
runs them: a synthetic block, and a photo simulated by the installed program. Their output must be
close to the truth. Installed headers may include only one another, Eigen and the standard library,
so that users of the libraries need no other headers.
"""

import csv
import pathlib
import re
import subprocess
import sys
import tempfile

# A small digital photo of open terrain: takes seconds.
SIMULATE = ("--photos", "1", "--camera-preset", "digital", "--pixel-size-um", "60", "--gsd-m", "0.75",
            "--relief-m", "50", "--bare", "--earth", "flat")
MOST_SIGMAS = 4  # largest normalised error of a pose element
FOREIGN_HEADER = re.compile(r"#\s*include\s*<(?!Eigen/)([^>]*[./][^>]*)>")


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")
    return done.stdout


def complaints_about_headers(folder):
    headers = list(folder.rglob("*.h"))
    found = [] if headers else [f"{folder}: no header was installed"]
    for header in headers:
        found += [f"{header.relative_to(folder)}: an installed header includes <{foreign}>"
                  for foreign in FOREIGN_HEADER.findall(header.read_text(encoding="utf-8"))]
    return found


def complaints_about_block(text):
    found = [] if "converged: 1" in text else ["adjust_points: did not converge"]
    for sigma, error in re.findall(r"sigma ([\d.]+), off by +(-?[\d.]+)", text):
        if abs(float(error)) > MOST_SIGMAS * float(sigma):
            found.append(f"adjust_points: off by {error}, sigma {sigma}")
    if text.count(", rejected:") != 1 or text.count(", adjusted\n") != 3:
        found.append(f"adjust_points: not three photos and one gross error:\n{text}")
    return found


def complaints_about_photo(text, truth):
    found = [] if "new_1_1: ok" in text else [f"orient_one_photo: not ok:\n{text}"]
    elements = re.findall(r"(\w+) \[\w+\] +(-?[\d.]+) +\+- ([\d.]+)", text)
    if len(elements) != 6:
        found.append(f"orient_one_photo: printed no pose:\n{text}")
    for name, value, sigma in elements:
        if abs(float(value) - float(truth[name])) > MOST_SIGMAS * float(sigma):
            found.append(f"orient_one_photo: {name} is {value} +- {sigma}, in truth {truth[name]}")
    return found


def orient_one_photo(orient, example, block):
    run(orient, "simulate", "--out", block, *SIMULATE)
    run(orient, "patchdb", "create", block / "patches.gpkg", "--crs", "EPSG:32635")
    run(orient, "patchdb", "harvest", block / "patches.gpkg",
        "--camera", block / "old/camera.toml", "--orientation", block / "old/orientation.csv",
        "--interior", block / "old/interior", "--dem", block / "dem.tif",
        block / "old/photos/old_1_1.tif")
    text = run(example, block / "camera.toml", block / "dem.tif", block / "patches.gpkg",
               block / "approx.csv", block / "scans/new_1_1.tif")
    with open(block / "truth/orientation.csv", encoding="utf-8") as table:
        return complaints_about_photo(text, next(csv.DictReader(table)))


def main(build, examples):
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        prefix = folder / "prefix"
        run("cmake", "--install", build, "--prefix", prefix)
        found = complaints_about_headers(prefix / "include")
        run("cmake", "-S", examples, "-B", folder / "build", "-G", "Ninja",
            f"-DCMAKE_PREFIX_PATH={prefix}")
        run("cmake", "--build", folder / "build")
        found += complaints_about_block(run(folder / "build/adjust_points"))
        found += orient_one_photo(prefix / "bin/orient", folder / "build/orient_one_photo",
                                  folder / "block")
    print("\n".join(found) or "the examples build on what is installed, and are right")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 3 else __doc__)
