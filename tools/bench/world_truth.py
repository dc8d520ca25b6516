"""The truth for worlds.py: true image positions of ground points, and those implied by a pose."""

import itertools
import json
import math
import statistics
import struct
import sys
import tomllib
import zlib

from block_truth import rotation

GRID = 15  # check points along a side of the frame


class Dem:
    """Heights of a single-band GeoTIFF: 32-bit floats in deflated strips."""

    def __init__(self, path):
        data, tags = path.read_bytes(), {}
        at, = struct.unpack_from("<I", data, 4)
        for entry in range(at + 2, at + 2 + 12 * struct.unpack_from("<H", data, at)[0], 12):
            tag, kind, count = struct.unpack_from("<HHI", data, entry)
            form = f"<{count}{ {3: 'H', 4: 'I', 12: 'd'}.get(kind, 'x')}"
            place = entry + 8
            if struct.calcsize(form) > 4:
                place, = struct.unpack_from("<I", data, place)
            tags[tag] = struct.unpack_from(form, data, place)
        if [data[:4], *map(tags.get, (258, 259, 317))] != [b"II*\0", (32,), (8,), (3,)]:
            sys.exit(f"{path}: not a GeoTIFF of deflated 32-bit floats with predictor 3")
        width, step, tie = tags[256][0], tags[33550], tags[33922]
        self.step, self.corner, self.rows = step[0], (tie[3], tie[4]), []
        for start, size in zip(tags[273], tags[279]):
            strip = zlib.decompress(data[start:start + size])
            for row in (strip[i:i + 4 * width] for i in range(0, len(strip), 4 * width)):
                total = bytes(byte & 255 for byte in itertools.accumulate(row))
                planes = [total[i * width:(i + 1) * width] for i in range(4)]
                self.rows.append(struct.unpack(f">{width}f", bytes(itertools.chain(*zip(*planes)))))

    def height(self, x, y):
        """Bilinear interpolation between cell centres."""
        col, row = (x - self.corner[0]) / self.step - 0.5, (self.corner[1] - y) / self.step - 0.5
        i, j = math.floor(row), math.floor(col)
        if not (0 <= i < len(self.rows) - 1 and 0 <= j < len(self.rows[0]) - 1):
            raise ValueError("a photo sees beyond the DEM")
        upper, lower = (r[j] + (col - j) * (r[j + 1] - r[j]) for r in self.rows[i:i + 2])
        return upper + (row - i) * (lower - upper)


def distortion(camera, x, y):
    """Lens distortion at x and y from the principal point, mm."""
    lens = camera.get("distortion", {"model": "brown"})
    if lens["model"] != "brown":
        sys.exit(f"{camera['name']}: a camera whose distortion is not brown")
    (k1, k2, k3), (p1, p2) = lens.get("k", (0, 0, 0)), lens.get("p", (0, 0))
    r2 = x * x + y * y
    radial = r2 * (k1 + r2 * (k2 + r2 * k3))
    return (x * radial + p1 * (r2 + 2 * x * x) + 2 * p2 * x * y,
            y * radial + p2 * (r2 + 2 * y * y) + 2 * p1 * x * y)


def photo_of(camera, pose, ground):
    """Photo coordinates of a ground point, mm; a point behind the camera comes out far away."""
    turn = rotation(pose["omega"], pose["phi"], pose["kappa"])
    offset = [g - pose[axis] for g, axis in zip(ground, "xyz")]
    d = [sum(turn[row][col] * offset[row] for row in range(3)) for col in range(3)]
    x, y = (-camera["principal_distance_mm"] * a / min(d[2], -1e-3) for a in d[:2])
    return [p + a + b for p, a, b in
            zip(camera["principal_point_mm"], (x, y), distortion(camera, x, y))]


def ground_of(camera, pose, photo, height):
    """First intersection of a photo point's ray with the ground, height(x, y)."""
    measured = [a - p for a, p in zip(photo, camera["principal_point_mm"])]
    ideal = measured
    for _ in range(20):
        ideal = [a - b for a, b in zip(measured, distortion(camera, *ideal))]
    turn = rotation(pose["omega"], pose["phi"], pose["kappa"])
    ray = [sum(a * b for a, b in zip(row, (*ideal, -camera["principal_distance_mm"])))
           for row in turn]

    def at(depth):  # below the projection centre, m
        return [pose[axis] - depth * part / ray[2] for axis, part in zip("xyz", ray)]

    def above(depth):
        x, y, z = at(depth)
        return z > height(x, y)

    near, step = 0.0, 2.0
    while above(near + step):
        near += step
    while step > 1e-7:
        step /= 2
        near += step if above(near + step) else 0
    return at(near)


def exact_photo(pixel_map, pixel):
    """The cubic transformation photo <- pixel."""
    u, v = (2 * a / pixel_map[side] - 1 for a, side in zip(pixel, ("width", "height")))
    return [sum(c * v**i * u**j for i, row in enumerate(pixel_map[name]) for j, c in enumerate(row))
            for name in ("Mx", "My")]


def affine_pixel(photo_from_pixel, photo):
    (a, b, x0), (c, d, y0) = photo_from_pixel
    x, y, det = photo[0] - x0, photo[1] - y0, a * d - b * c
    return (d * x - b * y) / det, (a * y - c * x) / det


def check_points(camera, truth, height):
    """Ground points distributed over the frame, and their true pixels."""
    points, (width, depth) = [], camera["frame_mm"]
    centre = camera.get("frame_centre_mm", (0, 0))
    for i, j in itertools.product(range(GRID), repeat=2):
        pixel = affine_pixel(truth["affine_photo_from_pixel"]["best_fit_frame"],
                             [centre[0] + width * ((i + 0.5) / GRID - 0.5),
                              centre[1] + depth * ((j + 0.5) / GRID - 0.5)])
        photo = exact_photo(truth["pixel_map"], pixel)
        points.append((ground_of(camera, truth["eo"], photo, height), pixel))
    return points


def rms_px(camera, pose, points, pixel_of):
    """pixel_of: the film transform, pixel <- photo."""
    pairs = [(pixel_of(photo_of(camera, pose, ground)), pixel) for ground, pixel in points]
    return math.sqrt(statistics.fmean(math.dist(*pair) ** 2 for pair in pairs))


def stated_px(camera, pose, covariance, points, pixel_of):
    """Expected rms_px of a pose with this covariance (in m and radians)."""
    steps = {"x": 0.01, "y": 0.01, "z": 0.01, "omega": 1e-4, "phi": 1e-4, "kappa": 1e-4}
    variances = []
    for ground, _ in points:
        here = pixel_of(photo_of(camera, pose, ground))
        by = []  # d pixel / d element
        for element, step in steps.items():
            there = pixel_of(photo_of(camera, {**pose, element: pose[element] + step}, ground))
            unit = step if element in "xyz" else math.radians(step)
            by.append([(b - a) / unit for a, b in zip(here, there)])
        variances.append(sum(by[i][axis] * covariance[i][j] * by[j][axis] for axis in (0, 1)
                             for i in range(6) for j in range(6)))
    return math.sqrt(statistics.fmean(variances))


class Truth:
    """True poses, film deformation and check points of a world's new photos."""

    def __init__(self, place):
        self.all = json.loads((place / "truth.json").read_text(encoding="utf-8"))
        self.photos = self.all["photos"]
        self.camera = tomllib.loads((place / "camera.toml").read_text(encoding="utf-8"))
        self.place, self.dem = place, Dem(place / "dem.tif")
        self.points = {name: check_points(self.camera, photo, self.dem.height)
                       for name, photo in self.photos.items()}

    def rms_px(self, photo, pose, photo_from_pixel):
        return rms_px(self.camera, pose, self.points[photo],
                      lambda mm: affine_pixel(photo_from_pixel, mm))

    def stated_px(self, photo, pose, covariance, photo_from_pixel):
        return stated_px(self.camera, pose, covariance, self.points[photo],
                         lambda mm: affine_pixel(photo_from_pixel, mm))


def made_up():
    """A camera, a photo and a DEM: hills of 40 m, deformed film, kappa 45 degrees."""
    camera = {"name": "made up", "principal_distance_mm": 100.0, "principal_point_mm": [0.1, -0.2],
              "frame_mm": [80.0, 60.0],
              "distortion": {"model": "brown", "k": [1e-6, -1e-10, 0.0], "p": [1e-6, -2e-6]}}
    photo = {"gsd_m": 0.25, "nonaffine_rms_um": 2.73,  # the map's integral over the frame
             "eo": {"x": 5e5, "y": 5e6, "z": 1100.0, "omega": 2.0, "phi": -3.0, "kappa": 45.0},
             "pixel_map": {"width": 3600, "height": 2800,
                           "Mx": [[0, 45, 0, 2e-3], [0, 0, 0, 0], [0, 1e-2, 0, 0], [0, 0, 0, 0]],
                           "My": [[0, 0, 5e-3, 0], [-35, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]},
             "affine_photo_from_pixel":
                 {"best_fit_frame": [[0.025, 0, -45], [0, -0.025, 35]]}}
    return camera, photo, lambda x, y: 100 + 20 * math.sin(x / 90) * math.cos(y / 70)


def errors_of(name, camera, photo, height):
    """Errors in the geometry of a photo, as sentences."""
    points, eo = check_points(camera, photo, height), photo["eo"]
    affine = photo["affine_photo_from_pixel"]["best_fit_frame"]

    def exact(mm):
        pixel = affine_pixel(affine, mm)
        for _ in range(20):
            off = [a - b for a, b in zip(mm, exact_photo(photo["pixel_map"], pixel))]
            step = affine_pixel([[*row[:2], 0] for row in affine], off)
            pixel = [a + b for a, b in zip(pixel, step)]
        return pixel

    def rms(**moved):
        return rms_px(camera, {**eo, **moved}, points, exact)

    def stated(element, sigma):
        at = list("xyz").index(element) if element in "xyz" else 5
        covariance = [[sigma**2 if i == j == at else 0 for j in range(6)] for i in range(6)]
        return stated_px(camera, eo, covariance, points, exact)

    pixel_mm = math.hypot(affine[0][0], affine[1][0])
    radius_px = math.hypot(*camera["frame_mm"]) / math.sqrt(12) / pixel_mm
    cases = [("the truth", rms(), 0, 1e-4),
             ("1 m to the east", rms(x=eo["x"] + 1), 1 / photo["gsd_m"], 0.1),
             ("0.1 degrees of kappa", rms(kappa=eo["kappa"] + 0.1),
              math.radians(0.1) * radius_px, 0.1),
             ("a stated metre to the east", stated("x", 1), rms(x=eo["x"] + 1), 0.01),
             ("stated 0.1 degrees of kappa", stated("kappa", math.radians(0.1)),
              rms(kappa=eo["kappa"] + 0.1), 0.01),
             ("the best affine film",
              rms_px(camera, eo, points, lambda mm: affine_pixel(affine, mm)),
              1e-3 * photo["nonaffine_rms_um"] / pixel_mm, 0.15)]
    return [f"{name}: {what}: {found:.4f} px, not {expected:.4f}"
            for what, found, expected, share in cases
            if abs(found - expected) > share * (expected or 1)]


def self_test(data):
    """Tests the geometry; data: the folder of worlds, if it exists."""
    wrong, places = errors_of("made up", *made_up()), sorted(data.glob("*/truth.json"))
    for truth in (Truth(path.parent) for path in places):
        for name, photo in truth.photos.items():
            wrong += errors_of(f"{truth.place.name} {name}", truth.camera, photo, truth.dem.height)
    print("\n".join(wrong) or "poses are judged as they should be: a made-up photo"
          + (f" and {len(places)} worlds" if places else f"; skipped: no worlds in {data}"))
    return 1 if wrong else 0
