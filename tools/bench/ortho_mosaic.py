#!/usr/bin/env python3
"""Time and memory of `orient ortho --mosaic`: does memory grow with the mosaic?

    ortho_mosaic.py ORIENT FOLDER [SIDE [COUNT...]]    photos of SIDE x SIDE pixels (9200), 16 bit;
                                                       blocks of COUNT photos (4 and 16)

One photo of a simulated world stands for all photos of a block: in rows of four, with 60 % forward
and 30 % side overlap, vertical over a plane. For each block, a plain mosaic is made, and one with
radiometric balancing and seamlines of least difference (--balance --least-difference), which uses
the orthophotos of the first. Memory is the peak resident set size.
"""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

from ortho_speed import make_world, run

ACROSS = 4  # photos in a row


def timed(words):
    start = time.monotonic()
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"failed: {words}")
    return time.monotonic() - start, usage.ru_maxrss / 1024


def lay_out(folder, scan, pose, count):
    """Scans and poses of `count` photos, and a DEM of a plane below all of them."""
    block = folder / f"of_{count}"
    shutil.rmtree(block, ignore_errors=True)
    block.mkdir()
    ground = 100.0
    side_m = 56.0 / 60.124 * (float(pose["z"]) - ground)  # the simulated camera's frame
    scans, rows = [], []
    for i in range(count):
        name = f"photo_{i + 1:03}"
        (block / f"{name}.tif").symlink_to(scan.resolve())
        scans.append(block / f"{name}.tif")
        rows.append([name, float(pose["x"]) + 0.4 * side_m * (i % ACROSS),
                     float(pose["y"]) + 0.7 * side_m * (i // ACROSS), pose["z"], 0, 0, 0])
    with open(block / "poses.csv", "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([["filename", "x", "y", "z", "omega", "phi", "kappa"], *rows])
    (block / "poses.prj").write_text("EPSG:32635\n", encoding="utf-8")
    (x0, y0), (x1, y1) = [[pick(row[i] for row in rows) + sign * side_m for i in (1, 2)]
                          for pick, sign in ((min, -1), (max, 1))]
    run(["gdal_create", "-q", "-outsize", 200, 200, "-bands", 1, "-burn", ground, "-ot", "Float32",
         "-a_srs", "EPSG:32635", "-a_ullr", x0, y1, x1, y0, block / "dem.tif"])
    return block, scans


def main(arguments):
    orient, folder = pathlib.Path(arguments[0]).resolve(), pathlib.Path(arguments[1])
    side = int(arguments[2]) if len(arguments) > 2 else 9200
    folder.mkdir(parents=True, exist_ok=True)
    scan, _ = make_world(orient, folder, side)
    with open(folder / "poses.csv", encoding="utf-8") as file:
        pose = next(csv.DictReader(file))
    for count in [int(word) for word in arguments[3:]] or (4, 16):
        block, scans = lay_out(folder, scan, pose, count)
        words = [orient, "ortho", "--quiet", block / "poses.csv", *scans, "--camera", folder / "camera.toml",
                 "--dem", block / "dem.tif", "--mosaic"]
        for label, further in (("orthophotos, mosaic", []),
                               ("one tone, least difference",
                                ["--balance", "--least-difference", "--resume"])):
            (block / "ortho/seamlines.gpkg").unlink(missing_ok=True)
            seconds, memory = timed([*words, *further])
            size = json.loads(run(["gdalinfo", "-json", block / "ortho/mosaic.tif"]))["size"]
            print(f"{count:3} photos, {label:26}  {size[0]:6} x {size[1]:5} px  {seconds:6.1f} s  "
                  f"{memory:5.0f} MB", flush=True)
        shutil.rmtree(block)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1:])
