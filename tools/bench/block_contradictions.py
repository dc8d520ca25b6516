#!/usr/bin/env python3
"""Blocks with contradictory inputs: are `ok` photos right, and are the causes of the rest named?

    block_contradictions.py PROGRAM FOLDER [CASE ...]

Six simulated digital photos in two strips (1 m GSD, 200 m relief, no objects), patches from one
orthophoto, and one fault in each case:

    sound                    none
    sheets_1m, sheets_2m     the orthophoto as two adjoining sheets, the eastern one displaced by
                             1.1 or 2.2 m
    sheet_turned             the eastern sheet rotated by 0.3 degrees
    dem_step                 DEM 10 m too high in its eastern half, for patches and block
    scan_cropped             the 20 leftmost columns of one scan missing, its width unchanged
    dem_45m                  the whole DEM 45 m too high: a different height datum
    approximations_45m       the approximations 45 m too high: the same the other way round

FOLDER keeps the block; delete it to have it simulated again. Printed for the block, and for its
photos from their own patches alone ("alone"): how many are ok, weak and failed, and which are
wrong, i.e. ok but off the truth by more than 1 px (RMS over the check points) and with a normalised
error above 3. Then the reasons of the block, and its notes.
"""

import collections
import json
import math
import pathlib
import shutil
import sys

sys.dont_write_bytecode = True  # beside the sources
import numpy as np  # noqa: E402
from osgeo import gdal  # noqa: E402

from block_truth import judge, principal_distance_mm  # noqa: E402
from result_jobs import Job, moved_table  # noqa: E402

gdal.UseExceptions()
SIMULATE = ["--photos", 6, "--strips", 2, "--gsd-m", 1, "--camera-preset", "digital", "--pixel-size-um",
            40, "--ortho", "--bare", "--relief-m", 200, "--seed", 11]
BLOCK = """crs = "EPSG:32635"
dem = "dem.tif"
patchdb = "patches.gpkg"
camera = "camera.toml"
photos = ["scans/*.tif"]
approximations = "approx.csv"
[approximate_accuracy]
position_m = 10
attitude_deg = 3
"""
WRONG_PX, WRONG_SIGMAS = 1.0, 3.0


class Image:
    """`place`: x, dx by column, dx by row, y, dy by column, dy by row, as in GDAL."""

    def __init__(self, values, place, crs):
        self.values, self.place, self.crs = values, list(place), crs

    @staticmethod
    def read(path):
        source = gdal.Open(str(path))
        return Image(source.ReadAsArray(), source.GetGeoTransform(), source.GetProjection())

    def write(self, path):
        rows, cols = self.values.shape
        kind = gdal.GDT_Byte if self.values.dtype == np.uint8 else gdal.GDT_Float32
        out = gdal.GetDriverByName("GTiff").Create(str(path), cols, rows, 1, kind)
        if self.crs:
            out.SetProjection(self.crs)
            out.SetGeoTransform(self.place)
        out.GetRasterBand(1).WriteArray(self.values)


def sheets(folder):
    """Splits the orthophoto; writes the western half and returns the eastern one."""
    whole = Image.read(folder / "ortho.tif")
    half, place = whole.values.shape[1] // 2, list(whole.place)
    place[0] += half * place[1]
    (folder / "ortho.tif").unlink()
    Image(whole.values[:, :half], whole.place, whole.crs).write(folder / "ortho_west.tif")
    return Image(whole.values[:, half:], place, whole.crs)


def displace_sheet(folder, metres):
    east = sheets(folder)
    east.place[0] += metres
    east.place[3] -= metres / 2
    east.write(folder / "ortho_east.tif")


def turn_sheet(folder, degrees):
    """Rotates the eastern sheet about its centre."""
    east = sheets(folder)
    rows, cols = east.values.shape
    x, dx, _, y, _, dy = east.place
    middle = x + cols * dx / 2, y + rows * dy / 2
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    off = x - middle[0], y - middle[1]
    east.place = [middle[0] + c * off[0] - s * off[1], c * dx, -s * dy,
                  middle[1] + s * off[0] + c * off[1], s * dx, c * dy]
    east.write(folder / "ortho_east.tif")


def raise_dem(folder, metres, eastern_half):
    dem = Image.read(folder / "dem.tif")
    dem.values[:, dem.values.shape[1] // 2 if eastern_half else 0:] += metres
    dem.write(folder / "dem.tif")


def crop_scan(folder, columns):
    path = folder / "scans/new_1_2.tif"
    values = np.pad(Image.read(path).values[:, columns:], [(0, 0), (0, columns)])
    path.unlink()
    Image(values, [], "").write(path)


def raise_approximations(folder, metres):
    table = folder / "approx.csv"
    table.write_text(moved_table(table.read_text(), lambda _, row: [
        *row[:2], row[2] + metres, *row[3:]]))


CASES = {
    "sound": lambda folder: None,
    "sheets_1m": lambda folder: displace_sheet(folder, 1),
    "sheets_2m": lambda folder: displace_sheet(folder, 2),
    "sheet_turned": lambda folder: turn_sheet(folder, 0.3),
    "dem_step": lambda folder: raise_dem(folder, 10, True),
    "scan_cropped": lambda folder: crop_scan(folder, 20),
    "dem_45m": lambda folder: raise_dem(folder, 45, False),
    "approximations_45m": lambda folder: raise_approximations(folder, 45),
}


def orient(program, start, folder, spoil):
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "scans").mkdir(parents=True)
    for scan in sorted((start / "scans").glob("*.tif")):
        (folder / "scans" / scan.name).symlink_to(scan)
    for file in ("dem.tif", "approx.csv", "approx.prj", "camera.toml", "old/ortho.tif"):
        shutil.copy(start / file, folder)
    spoil(folder)
    job = Job(program, folder, None)
    job.write("block.toml", BLOCK)
    orthos = job.files("ortho*.tif")
    job.run("patchdb", "create", "patches.gpkg", "--crs", "EPSG:32635")
    job.run("patchdb", "harvest-ortho", "patches.gpkg", "--ortho", *orthos, "--dem", "dem.tif",
            "--max-per-ortho", 900 // len(orthos))
    job.run("block", "block.toml")


def told(name, results, start):
    """A line summarising (truth, result) pairs of photos."""
    states, wrong = collections.Counter(), []
    for photo, found in results:
        states[found["status"]] += 1
        verdict = judge(found, photo, start["check_points"], start["distance_mm"] /
                        (1e-3 * photo["scan"]["pixel_size_um"]))
        px, sigmas = map(math.sqrt, verdict or (0, 0))
        if found["status"] == "ok" and px > WRONG_PX and sigmas > WRONG_SIGMAS:
            wrong.append(f"{photo['photo']} {px:.1f} px, {sigmas:.1f} sigma")
    return (f"{name}: {states['ok']} ok, {states['weak']} weak, {states['failed']} failed; wrong: "
            f"{'; '.join(wrong) or 'none'}")


def report(name, folder, start):
    truth = json.loads((start / "truth.json").read_text())
    truth["distance_mm"] = principal_distance_mm(start)
    results = [(photo, json.loads((folder / f"out/{photo['photo']}.exterior.json").read_text()))
               for photo in truth["photos"]]
    print(told(name, results, truth))
    print("   ", told("alone", [(photo, found["alone"]) for photo, found in results], truth))
    codes = collections.Counter(code for _, found in results for code in {
        finding["code"] for finding in found["findings"] if finding["at_best"] != "ok"})
    for code, count in codes.most_common():
        print(f"    {code} ({count})")
    for note in json.loads((folder / "out/block.json").read_text())["messages"]:
        print(f"    note: {note}")
    sys.stdout.flush()


def main():
    if len(sys.argv) < 3 or not set(sys.argv[3:]) <= CASES.keys():
        sys.exit(__doc__)
    program, home = (pathlib.Path(path).resolve() for path in sys.argv[1:3])
    start = home / "start"
    if not start.exists():
        home.mkdir(parents=True, exist_ok=True)
        Job(program, home, None).run("simulate", "--out", "start", *SIMULATE)
    for name in sys.argv[3:] or CASES:
        orient(program, start, home / name, CASES[name])
        report(name, home / name, start)


if __name__ == "__main__":
    main()
