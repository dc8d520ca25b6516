#!/usr/bin/env python3
"""Blocks whose inputs contradict one another: is what is `ok` right, and is the rest named?

    block_contradictions.py PROGRAM FOLDER [CASE ...]

Six simulated digital photos in two strips (1 m pixels, 200 m relief, no objects), patches from one
orthophoto, and one thing wrong in each case:

    sound                    nothing
    sheets_1m, sheets_2m     the orthophoto as two sheets that adjoin, the eastern one displaced by
                             1.1 or 2.2 m
    sheet_turned             the eastern one turned by 0.3 degrees
    dem_step                 east of the middle the DEM lies 10 m too high, for patches and block
    scan_cropped             of one photo the 20 leftmost columns are missing, the image as wide
    dem_45m                  all of the DEM 45 m too high: another height datum
    approximations_45m       the approximations 45 m too high: the same the other way round

FOLDER keeps the block; delete it to have it made anew. A photo is told `wrong` that is `ok` and more
than 1 px (RMS over the check points) and three of its sigmas (normalised error) off the truth; notes
are the block's.
"""

import collections
import json
import math
import pathlib
import re
import shutil
import subprocess
import sys

sys.dont_write_bytecode = True  # beside the sources
import numpy as np  # noqa: E402
from osgeo import gdal  # noqa: E402

from block_truth import judge  # noqa: E402

gdal.UseExceptions()
SIMULATE = ["--photos", 6, "--strips", 2, "--gsd-m", 1, "--camera-preset", "digital", "--pixel-size-um",
            40, "--ortho", "--bare", "--relief-m", 200, "--seed", 11]
WRONG_PX, WRONG_SIGMAS = 1.0, 3.0


class Image:
    def __init__(self, path):
        source = gdal.Open(str(path))
        self.values, self.crs = source.ReadAsArray(), source.GetProjection()
        self.place = list(source.GetGeoTransform())

    def write(self, path):
        rows, cols = self.values.shape[-2:]
        bands = self.values.reshape(-1, rows, cols)
        kind = gdal.GDT_Byte if self.values.dtype == np.uint8 else gdal.GDT_Float32
        out = gdal.GetDriverByName("GTiff").Create(str(path), cols, rows, len(bands), kind)
        if self.crs:
            out.SetProjection(self.crs)
            out.SetGeoTransform(self.place)
        for number, band in enumerate(bands, 1):
            out.GetRasterBand(number).WriteArray(band)


def sheet(image, east):
    part, half = Image.__new__(Image), image.values.shape[-1] // 2
    part.crs, part.place = image.crs, list(image.place)
    part.values = image.values[..., half:] if east else image.values[..., :half]
    part.place[0] += half * image.place[1] if east else 0
    return part


def turned(image, degrees):
    """About its middle."""
    rows, cols = image.values.shape[-2:]
    x, dx, _, y, _, dy = image.place
    middle = x + cols * dx / 2, y + rows * dy / 2
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    off = x - middle[0], y - middle[1]
    image.place = [middle[0] + c * off[0] - s * off[1], c * dx, -s * dy,
                   middle[1] + s * off[0] + c * off[1], s * dx, c * dy]


class Case:
    def __init__(self, program, start, name):
        self.program, self.start, self.name = program, start, name
        self.folder = start.parent / name
        shutil.rmtree(self.folder, ignore_errors=True)
        (self.folder / "scans").mkdir(parents=True)
        for scan in sorted((start / "scans").glob("*.tif")):
            (self.folder / "scans" / scan.name).symlink_to(scan)
        for file in ("dem.tif", "approx.csv", "approx.prj", "camera.toml"):
            shutil.copy(start / file, self.folder)
        self.sheets = [Image(start / "old/ortho.tif")]

    def spoil(self):
        if self.name.startswith("sheet"):
            whole = self.sheets[0]
            self.sheets = [sheet(whole, False), sheet(whole, True)]
            if self.name == "sheet_turned":
                turned(self.sheets[1], 0.3)
            else:
                metres = 1 if self.name == "sheets_1m" else 2
                self.sheets[1].place[0] += metres
                self.sheets[1].place[3] -= metres / 2
        if self.name.startswith("dem"):
            dem = Image(self.start / "dem.tif")
            half = dem.values.shape[1] // 2
            dem.values[:, half if self.name == "dem_step" else 0:] += 10 if self.name == "dem_step" else 45
            dem.write(self.folder / "dem.tif")
        if self.name == "scan_cropped":
            path = self.folder / "scans/new_1_2.tif"
            scan = Image(path)
            scan.values = np.pad(scan.values[..., 20:], [(0, 0)] * (scan.values.ndim - 1) + [(0, 20)])
            path.unlink()
            scan.crs = ""
            scan.write(path)
        if self.name == "approximations_45m":
            path = self.folder / "approx.csv"
            head, *rows = path.read_text().splitlines()
            z = head.split(",").index("z")
            moved = [[str(float(cell) + 45) if i == z else cell for i, cell in enumerate(row.split(","))]
                     for row in rows]
            path.write_text("\n".join([head, *map(",".join, moved)]) + "\n")

    def orient(self):
        for number, part in enumerate(self.sheets):
            part.write(self.folder / f"sheet{number}.tif")
        (self.folder / "block.toml").write_text(f"""crs = "EPSG:32635"
dem = "dem.tif"
patchdb = "patches.gpkg"
camera = "camera.toml"
photos = ["scans/*.tif"]
approximations = "approx.csv"
[approximate_accuracy]
position_m = 10
attitude_deg = 3
""")
        sheets = [self.folder / f"sheet{number}.tif" for number in range(len(self.sheets))]
        patches = self.folder / "patches.gpkg"
        run(self.program, "patchdb", "create", patches, "--crs", "EPSG:32635")
        run(self.program, "patchdb", "harvest-ortho", patches, "--ortho", *sheets, "--dem",
            self.folder / "dem.tif", "--max-per-ortho", 900 // len(sheets))
        run(self.program, "block", self.folder / "block.toml", "--overwrite")


def run(*words):
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        sys.exit(f"{words}: exit code {done.returncode}\n{done.stderr}")


def report(case):
    truth = json.loads((case.start / "truth.json").read_text())
    camera = (case.start / "camera.toml").read_text()
    distance_mm = float(re.search(r"principal_distance_mm\s*=\s*([\d.]+)", camera).group(1))
    states, wrong, codes = collections.Counter(), [], collections.Counter()
    for photo in truth["photos"]:
        found = json.loads((case.folder / f"out/{photo['photo']}.exterior.json").read_text())
        states[found["status"]] += 1
        codes.update({finding["code"] for finding in found["findings"] if finding["at_best"] != "ok"})
        verdict = judge(found, photo, truth["check_points"],
                        distance_mm / (1e-3 * photo["scan"]["pixel_size_um"]))
        if verdict and found["status"] == "ok":
            px, sigmas = map(math.sqrt, verdict)
            if px > WRONG_PX and sigmas > WRONG_SIGMAS:
                wrong.append(f"{photo['photo']} {px:.1f} px, {sigmas:.1f} sigma")
    notes = json.loads((case.folder / "out/block.json").read_text())["messages"]
    print(f"{case.name}: {states['ok']} ok, {states['weak']} weak, {states['failed']} failed; wrong: "
          f"{'; '.join(wrong) or 'none'}")
    for code, count in codes.most_common():
        print(f"    {code} ({count})")
    for note in notes:
        print(f"    note: {note}", flush=True)


CASES = ["sound", "sheets_1m", "sheets_2m", "sheet_turned", "dem_step", "scan_cropped", "dem_45m",
         "approximations_45m"]


def main():
    if len(sys.argv) < 3 or not set(sys.argv[3:]) <= set(CASES):
        sys.exit(__doc__)
    program, start = sys.argv[1], pathlib.Path(sys.argv[2]).resolve() / "start"
    if not start.exists():
        run(program, "simulate", "--out", start, *SIMULATE)
    for name in sys.argv[3:] or CASES:
        case = Case(program, start, name)
        case.spoil()
        case.orient()
        report(case)


if __name__ == "__main__":
    main()
