#!/usr/bin/env python3
"""Speed of orthophoto production, compared with gdalwarp and with copying the pixels.

    ortho_speed.py ORIENT FOLDER [SIDE]    works in FOLDER; photos of SIDE x SIDE pixels (9200), 16 bit

An enlarged digital photo of a simulated world, over the DEM of that world. gdalwarp has the same
photo with RPCs of the same geometry and the DEM, and with a grid of ground control points for its
thin-plate splines; cubic interpolation, all cores, the same compression (COG, deflate). The copy is
made of the finished orthophoto by gdal_translate. Best of three runs each; memory is the peak
resident set size. Needs gdal-bin.
"""

import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import time

COG = ["-of", "COG", "-co", "COMPRESS=DEFLATE", "-co", "PREDICTOR=YES", "-co", "NUM_THREADS=ALL_CPUS"]
RUNS = 3


def run(words, text=None):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True,
                          input=text).stdout


def timed(words):
    """Seconds and megabytes of the best run."""
    best = None
    for _ in range(RUNS):
        start = time.monotonic()
        process = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit(f"failed: {words}")
        result = (time.monotonic() - start, usage.ru_maxrss / 1024)
        best = min(best or result, result)
    return best


def rotation(omega, phi, kappa):
    (so, co), (sp, cp), (sk, ck) = [(math.sin(a), math.cos(a)) for a in (omega, phi, kappa)]
    return [[cp * ck, -cp * sk, sp],
            [co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp],
            [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp]]


class Photo:
    """A digital photo without distortion: row and column are linear fractions in X, Y, Z."""

    def __init__(self, pose, c_mm, pixel_mm, side):
        self.centre = [pose[key] for key in "xyz"]
        r = rotation(*[math.radians(pose[key]) for key in ("omega", "phi", "kappa")])
        down = [r[i][2] for i in range(3)]
        scale = c_mm / pixel_mm
        self.column = [-scale * r[i][0] + 0.5 * side * down[i] for i in range(3)]
        self.row = [scale * r[i][1] + 0.5 * side * down[i] for i in range(3)]
        self.below = down

    def pixel(self, ground):
        d = [ground[i] - self.centre[i] for i in range(3)]
        dot = [sum(a * b for a, b in zip(d, line)) for line in (self.column, self.row, self.below)]
        return dot[0] / dot[2], dot[1] / dot[2]


def heights(dem, places):
    lines = "\n".join(f"{x} {y}" for x, y in places)
    return [float(h) for h in run(["gdallocationinfo", "-valonly", "-geoloc", dem], lines).split()]


def rpc_of(photo, side, ground, crs):
    """Linear fractions in latitude, longitude and height about the centre of the ground."""
    x0, y0, x1, y1, z = ground
    middle, half = ((x0 + x1) / 2, (y0 + y1) / 2), max(x1 - x0, y1 - y0) / 2
    places = [middle, (middle[0] + half, middle[1]), (middle[0], middle[1] + half)]
    told = run(["gdaltransform", "-s_srs", crs, "-t_srs", "EPSG:4326", "-output_xy"],
               "\n".join(f"{x} {y}" for x, y in places)).split()
    lon, lat = [[float(v) for v in told[i::2]] for i in (0, 1)]
    # (dlon, dlat) = M (dx, dy); the inverse converts degrees to metres.
    a, b, c, d = [(v[i] - v[0]) / half for v in (lon, lat) for i in (1, 2)]
    det = a * d - b * c
    inverse = [[d / det, -b / det], [-c / det, a / det]]
    degrees, tall = half * max(abs(a), abs(d)), 500.0

    def linear(line):
        constant = sum(l * (g - p) for l, g, p in zip(line, (*middle, z), photo.centre))
        by = [sum(line[i] * inverse[i][k] for i in range(2)) * degrees for k in range(2)]
        return [constant, *by, line[2] * tall]

    lines = {"LINE_NUM_COEFF": linear([r - 0.5 * side * b for r, b in zip(photo.row, photo.below)]),
             "LINE_DEN_COEFF": linear(photo.below),
             "SAMP_NUM_COEFF": linear([s - 0.5 * side * b for s, b in zip(photo.column, photo.below)]),
             "SAMP_DEN_COEFF": linear(photo.below)}
    rpc = {"LINE_OFF": side / 2 - 0.5, "SAMP_OFF": side / 2 - 0.5, "LAT_OFF": lat[0], "LONG_OFF": lon[0],
           "HEIGHT_OFF": z, "LINE_SCALE": side / 2, "SAMP_SCALE": side / 2, "LAT_SCALE": degrees,
           "LONG_SCALE": degrees, "HEIGHT_SCALE": tall}
    for name, values in lines.items():
        one = lines[name.replace("NUM", "DEN")][0] * (side / 2 if "NUM" in name else 1)
        rpc[name] = " ".join(repr(v / one) for v in values + [0.0] * 16)
    return rpc


def make_world(orient, folder, side):
    run([orient, "simulate", "--out", folder / "world", "--photos", 1, "--overwrite"])
    with open(folder / "world/truth/orientation.csv", encoding="utf-8") as file:
        pose = {k: v if k == "filename" else float(v) for k, v in next(csv.DictReader(file)).items()}
    scan = folder / f"world/scans/{pose['filename']}.tif"
    photo = folder / f"{pose['filename']}.tif"
    run(["gdal_translate", "-q", "-ot", "UInt16", "-scale", 0, 255, 0, 65535, "-outsize", side, side,
         "-r", "cubic", "-co", "TILED=YES", "-a_ullr", 0, 0, side, side, scan, photo])
    frame = 56.0  # the simulated camera's
    (folder / "camera.toml").write_text(
        f'name = "enlarged"\nkind = "digital"\nprincipal_distance_mm = 60.124\n'
        f"principal_point_mm = [0.0, 0.0]\nframe_mm = [{frame}, {frame}]\nimage_px = [{side}, {side}]\n")
    table = folder / "poses.csv"
    names = ["filename", "x", "y", "z", "omega", "phi", "kappa"]
    table.write_text(",".join(names) + "\n" + ",".join(str(pose[n]) for n in names) + "\n")
    table.with_suffix(".prj").write_text("EPSG:32635\n")
    return photo, Photo(pose, 60.124, frame / side, side)


def main(arguments):
    orient, folder = pathlib.Path(arguments[0]).resolve(), pathlib.Path(arguments[1])
    side = int(arguments[2]) if len(arguments) > 2 else 9200
    folder.mkdir(parents=True, exist_ok=True)
    scan, photo = make_world(orient, folder, side)
    dem, crs = folder / "world/dem.tif", "EPSG:32635"
    made = folder / "ortho" / f"{scan.stem}.ortho.tif"
    ours = timed([orient, "ortho", folder / "poses.csv", scan, "--camera", folder / "camera.toml", "--dem",
                  dem, "--overwrite"])
    info = json.loads(run(["gdalinfo", "-json", made]))
    (x0, y1), (x1, y0) = [info["cornerCoordinates"][c] for c in ("upperLeft", "lowerRight")]
    grid = ["-te", x0, y0, x1, y1, "-ts", *info["size"], "-r", "cubic", "-multi", "-wo",
            "NUM_THREADS=ALL_CPUS", "-wm", 256, "-overwrite", "-q", *COG]
    places = [(x0 + (x1 - x0) * (i + 1) / 14, y0 + (y1 - y0) * (j + 1) / 14) for i in range(13)
              for j in range(13)]
    tall = heights(dem, places)
    gcps = [str(word) for (x, y), z in zip(places, tall)
            for word in ("-gcp", *photo.pixel((x, y, z)), x, y)]
    run(["gdal_translate", "-q", "-of", "VRT", "-a_srs", crs, *gcps, scan, folder / "gcps.vrt"])
    rpc = rpc_of(photo, side, (x0, y0, x1, y1, sum(tall) / len(tall)), crs)
    run(["gdal_translate", "-q", "-of", "VRT", scan, folder / "rpc.vrt"])
    vrt = (folder / "rpc.vrt").read_text()
    items = "".join(f'<MDI key="{k}">{v}</MDI>' for k, v in rpc.items())
    (folder / "rpc.vrt").write_text(
        vrt.replace("<VRTRasterBand", f'<Metadata domain="RPC">{items}</Metadata><VRTRasterBand', 1))
    others = {
        "gdalwarp -rpc": ["gdalwarp", "-rpc", "-to", f"RPC_DEM={dem}", "-t_srs", crs, *grid,
                          folder / "rpc.vrt", folder / "rpc.tif"],
        "gdalwarp -tps": ["gdalwarp", "-tps", "-t_srs", crs, *grid, folder / "gcps.vrt",
                          folder / "tps.tif"],
        "copy": ["gdal_translate", "-q", *COG, made, folder / "copy.tif"]}
    pixels = info["size"][0] * info["size"][1] / 1e6
    print(f"{info['size'][0]} x {info['size'][1]} px")
    print(f"orient ortho   {ours[0]:6.2f} s  {pixels / ours[0]:6.1f} Mpx/s  {ours[1]:5.0f} MB")
    for name, words in others.items():
        seconds, memory = timed(words)
        print(f"{name:14} {seconds:6.2f} s  {pixels / seconds:6.1f} Mpx/s  {memory:5.0f} MB, "
              f"{seconds / ours[0]:.2f} times orient's time")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1:])
