"""The jobs of compare_results.py: command lines for which two builds must give the same results."""

import json
import os
import pathlib
import shutil
import subprocess

PROJECT = pathlib.Path(__file__).resolve().parents[2]
CAMERAS = PROJECT / "data" / "cameras"
FORMATS = "opk ori patb bingo micmac metashape colmap opensfm asp".split()
COMMANDS = "commands.json"  # of a job: command lines and exit codes
CONSOLE = "console.txt"


class JobFailed(Exception):
    """A command failed that every build should manage."""


def shared_data():
    told = os.environ.get("ORIENT_SHARED_DATA")
    return pathlib.Path(told or PROJECT.parent / "shared" / "data").resolve()


class Job:
    def __init__(self, program, folder, data):
        self.program, self.folder, self.data = program, folder, data
        self.commands = []

    def run(self, *words):
        """Runs in the job's folder, so that the results do not contain its path."""
        line = [str(word) for word in words]
        done = subprocess.run([self.program, *line], cwd=self.folder, capture_output=True,
                              text=True, check=False)
        with open(self.folder / CONSOLE, "a", encoding="utf-8") as console:
            console.write(f"$ orient {' '.join(line)}\n{done.stdout}{done.stderr}")
        self.commands.append({"command": line, "exit_code": done.returncode})
        self.write(COMMANDS, json.dumps(self.commands, indent=1) + "\n")
        if done.returncode not in (0, 3):
            raise JobFailed(f"orient {' '.join(line)}: exit code {done.returncode}\n{done.stderr}")

    def read(self, name):
        return (self.folder / name).read_text(encoding="utf-8")

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")

    def files(self, pattern):
        return sorted(path.relative_to(self.folder) for path in self.folder.glob(pattern))


def moved_table(text, change):
    """An orientation table with change(photo, numbers) applied to its rows; None drops a row."""
    header, *rows = [line.split(",") for line in text.splitlines() if line]
    lines = [",".join(header)]
    for photo, *cells in rows:
        numbers = change(photo, [float(cell) for cell in cells])
        if numbers is not None:
            lines.append(",".join([photo, *(f"{number:.9f}" for number in numbers)]))
    return "\n".join(lines) + "\n"


def harvest(job, name, crs, *words):
    job.run("patchdb", "create", name, "--crs", crs)
    job.run("patchdb", "harvest", name, *words)


def of_old_photos(folder, interior=False):
    """Harvest options for the old photos of a simulated block."""
    words = ["--camera", f"{folder}old/camera.toml", "--dem", f"{folder}dem.tif",
             "--orientation", f"{folder}old/orientation.csv", f"{folder}old/photos/*.tif"]
    return words + (["--interior", f"{folder}old/interior"] if interior else [])


def demo(job):
    job.run("simulate", "--out", "block", "--photos", 3)
    harvest(job, "block/patches.gpkg", "EPSG:32635", *of_old_photos("block/", True))
    job.run("block", "block/block.toml")
    job.run("patchdb", "export", "block/patches.gpkg", "--csv", "patches.csv")


GNSS_BLOCK = """
[block]
check_share = 0.2
self_calibration = "camera"
pose_covariance = true

[gnss]
positions = "gnss.csv"
sigma_m = 0.1

[[strips]]
photos = ["new_1_*"]
[[strips]]
photos = ["new_2_*"]
"""


def strips(job):
    job.run("simulate", "--out", ".", "--photos", 6, "--strips", 2, "--seed", 2, "--gsd-m", 0.5,
            "--pixel-size-um", 50, "--film-bend-um", 5, "--dirty-marks", 1, "--mark-symbols",
            "--polarity", "negative", "--scan-orientation", "random", "--position-error-m", 5,
            "--attitude-error-deg", 1, "--old-film", "--ortho")
    job.run("interior", "old/photos/*.tif", "--camera", "old/camera.toml", "--out", "old_io")
    harvest(job, "patches.gpkg", "EPSG:32635", "--further-views", 2, *of_old_photos("", True))
    job.run("patchdb", "harvest-ortho", "patches.gpkg", "--ortho", "old/ortho.tif", "--dem",
            "dem.tif", "--max-per-ortho", 600)
    truth = job.read("truth/orientation.csv")
    noise = iter([3, -1, 4, -1, 5, -9, 2, 6, -5, 3, 5, -8, 9, 7, -9, 3, -2, 3])  # cm
    shift = (0.4, -0.3, 20)
    job.write("gnss.csv", moved_table(truth, lambda _, row: [
        value + by + 0.01 * next(noise) for value, by in zip(row, shift)] + row[3:]))
    block = job.read("block.toml")
    output = f'directory = "gnss"\nformats = {json.dumps(FORMATS)}'
    job.write("gnss.toml", block.replace('directory = "out"', output) + GNSS_BLOCK)
    job.run("block", "gnss.toml", "--no-feedback", "--quicklook")
    aside = {"new_1_2": None, "new_2_2": (0, 1800, 0, 0, 0, -137)}
    job.write("lost.csv", moved_table(job.read("approx.csv"), lambda photo, row: (
        None if photo == "new_1_2" else [a + b for a, b in zip(row, aside.get(photo, [0] * 6))])))
    shutil.copy(job.folder / "approx.prj", job.folder / "lost.prj")
    job.write("lost.toml", block.replace("approx.csv", "lost.csv").replace('"out"', '"lost"'))
    job.run("block", "lost.toml", "--no-feedback")
    job.run("convert", "gnss", "--to", "colmap,micmac", "--out", "resampled", "--remove-distortion",
            "--images", *job.files("scans/*.tif"))
    job.run("convert", "resampled", "--check")
    for name in ("colmap", "opensfm", "metashape"):
        job.run("convert", f"gnss/exports/{name}", "--from", name, "--to", "opk", "--out",
                f"back_{name}")


def reseau(job):
    job.run("simulate", "--out", ".", "--photos", 3, "--camera-preset", "reseau", "--seed", 23,
            "--pixel-size-um", 30, "--film-bend-um", 40, "--bare", "--gsd-m", 0.4,
            "--position-error-m", 3, "--attitude-error-deg", 0.5)
    harvest(job, "patches.gpkg", "EPSG:32635", *of_old_photos(""), "--colour")
    job.run("interior", "scans/*.tif", "--camera", "camera.toml", "--out", "out", "--micmac")
    job.run("exterior", "scans/*.tif", "--camera", "camera.toml", "--dem", "dem.tif",
            "--approximations", "approx.csv", "--patchdb", "patches.gpkg", "--interior", "out",
            "--out", "out", "--position-sigma-m", 3, "--attitude-sigma-deg", 0.5)


FRAMES = {"wild_rc10": ["0bbe1004", "0c8e8831", "5bdd5cf4"], "wild_18cm": ["66685fc2"],
          "zeiss_rmk_mid": ["0b4cb981"], "wild_rc8_23": ["0cec8b13"]}


def film(job):
    for camera, frames in FRAMES.items():
        job.run("interior", *(job.data / "film" / f"{frame}.jpg" for frame in frames), "--camera",
                CAMERAS / f"{camera}.toml", "--out", camera)
    job.run("interior", job.data / "film/66685fc2.jpg", "--camera", "auto", "--camera-library",
            CAMERAS, "--out", "auto")


# Signs of the errors in x, y, z, omega, phi, kappa.
ERRORS = {"0182": (1, -1, 1, 1, -1, 1), "0184": (-1, -1, 1, -1, 1, 1),
          "0251": (1, 1, -1, 1, 1, -1), "0253": (-1, 1, 1, -1, -1, -1)}


def wrong_by(text, position_m, attitude_deg, kappa_deg):
    sizes = [position_m] * 3 + [attitude_deg] * 2 + [kappa_deg]

    def change(photo, row):
        signs = ERRORS[photo.split("_")[-2]]
        return [value + sign * size for value, sign, size in zip(row, signs, sizes)]
    return moved_table(text, change)


def ngi(job):
    real = job.data / "ngi"
    crs, published = real / "published_orientation.prj", real / "published_orientation.csv"
    for name, errors in {"near": (10, 3, 3), "far": (600, 5, 130)}.items():
        job.write(f"{name}.csv", wrong_by(published.read_text(encoding="utf-8"), *errors))
        shutil.copy(crs, job.folder / f"{name}.prj")
    job.run("patchdb", "create", "orthos.gpkg", "--crs", crs)
    job.run("patchdb", "harvest-ortho", "orthos.gpkg", "--dem", real / "dem.tif", "--ortho",
            *(real / f"orthos/ngi_rgb_byte_{i}.tif" for i in (1, 2)))
    job.write("block.toml", f"""
crs = {json.dumps("".join(crs.read_text(encoding="utf-8").splitlines()))}
dem = "{real}/dem.tif"
patchdb = "orthos.gpkg"
camera = "{real}/camera.toml"
photos = ["{real}/photos/*.tif"]
approximations = "near.csv"
[approximate_accuracy]
position_m = 10
attitude_deg = 3
[output]
formats = ["opk", "colmap", "asp"]
""")
    job.run("block", "block.toml", "--no-feedback")
    photos = {n: next((real / "photos").glob(f"*_{n}_*.tif")) for n in ERRORS}
    common = ["--camera", real / "camera.toml", "--dem", real / "dem.tif"]
    harvest(job, "photos.gpkg", crs, *common, "--orientation", published, photos["0182"],
            photos["0184"])
    common += [photos["0251"], photos["0253"], "--patchdb", "photos.gpkg", "--no-feedback"]
    job.run("exterior", *common, "--approximations", "near.csv", "--out", "near")
    job.run("exterior", *common, "--approximations", "far.csv", "--out", "far",
            "--position-sigma-m", 600, "--attitude-sigma-deg", 5, "--kappa-sigma-deg", 180)


def world(job):
    place = job.data / "worlds" / "turned"
    scans = sorted((place / "scans").glob("*.tif"))
    old = sorted((place / "old_scans").glob("*.tif"))
    how = ["--pixel-size-um", 25, "--orientation", "r0"]
    job.run("interior", *old, "--camera", place / "camera_old.toml", *how, "--out", "old")
    job.run("interior", *scans, "--camera", place / "camera.toml", *how, "--out", "new")
    harvest(job, "patches.gpkg", "EPSG:32635", *old, "--camera", place / "camera_old.toml",
            "--orientation", place / "old_orientation.csv", "--interior", "old", "--dem",
            place / "dem.tif", "--further-views", 3)
    common = ["--camera", place / "camera.toml", "--dem", place / "dem.tif", "--patchdb",
              "patches.gpkg", "--interior", "new", "--no-feedback"]
    job.run("exterior", *scans, *common, "--approximations", place / "approx_mid.csv", "--out",
            "mid", "--position-sigma-m", 5, "--attitude-sigma-deg", 1,
            "--principal-distance-sigma-mm", 0.1)
    job.run("exterior", scans[1], *common, "--approximations", place / "approx_coarse.csv",
            "--out", "coarse", "--kappa-sigma-deg", 180)


# name: (what it does, folders of the shared data that it needs)
JOBS = {"demo": (demo, []), "strips": (strips, []), "reseau": (reseau, []),
        "film": (film, ["film"]), "ngi": (ngi, ["ngi"]), "world": (world, ["worlds/turned"])}
