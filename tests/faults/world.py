"""A small simulated world, every command that reads or writes files, and digests of its output."""

import hashlib
import json
import os
import pathlib
import re
import shutil
import sqlite3
import subprocess

SIMULATE = ["--gsd-m", 1.5, "--pixel-size-um", 150, "--bare", "--position-error-m", 3,
            "--attitude-error-deg", 0.5, "--ortho"]
LONGEST_S = 300  # a run takes a second; after this time, it hangs
TIME_OF_DAY = re.compile(r"\d{4}-\d\d-\d\dT[\d:.]+Z")
# An interrupted run may have learned, which changes the database that the next run reads.
DATABASE_DIGEST = re.compile(r"(patch database&quot;,&quot;path&quot;:&quot;[^&]*&quot;,&quot;digest&quot;:&quot;)\w+")


def tables(path):
    """All rows of a GeoPackage, without what differs between undisturbed runs (times of day, random
    token, ids of attempts, which are replaced if recorded again) or after an interrupted one."""
    raw = sqlite3.connect(path)  # a read-only connection would leave logs
    rows = []
    for (name,) in raw.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name"):
        if name in ("sqlite_sequence", "orient_content"):
            continue
        columns = [column[1] for column in raw.execute(f'PRAGMA table_info("{name}")')]
        kept = [c for c in columns if (name, c) != ("attempts", "id")]
        chosen = ", ".join(f'"{column}"' for column in kept) or "1"
        found = raw.execute(f'SELECT {chosen} FROM "{name}"').fetchall()
        texts = (TIME_OF_DAY.sub("", repr(row)) for row in found)
        rows.append((name, kept, sorted(DATABASE_DIGEST.sub(r"\1", text) for text in texts)))
    raw.close()
    return rows


def digest(path):
    if path.name == "run.json":  # when, and by which command
        return ""
    content = repr(tables(path)).encode() if path.suffix == ".gpkg" else path.read_bytes()
    if path.name == "regions.json":  # when its databases were modified
        content = re.sub(rb'"modified_ns": \d+', b"", content)
    if path.suffix == ".html":  # the same, in the report
        content = re.sub(rb'<section id="made">.*?</section>', b"", content, flags=re.DOTALL)
    return hashlib.sha256(content).hexdigest()


def is_log(path):
    """SQLite's own files beside a database; their contents are read with it."""
    return path.name.endswith(("-wal", "-shm", "-journal"))


def holds_changes(path):
    """Whether a log holds changes; read-only readers may leave an index or an empty log."""
    return not path.name.endswith("-shm") and path.stat().st_size > 0


class Command:
    """`needs`: files of the world to copy; `again`: options added when the command is repeated."""

    def __init__(self, needs, words, again=()):
        self.needs, self.words, self.again = needs, [str(word) for word in words], list(again)


class World:
    """Runs commands in `here`, a copy of the files of `start` that they need."""

    def __init__(self, orient, start, here, photos=2):
        self.orient, self.start, self.here = orient, start, here
        self.photos = [f"new_1_{i + 1}" for i in range(photos)]

    def make(self):
        start, old = self.start, self.start / "old"
        self.do("simulate", "--out", start, "--photos", len(self.photos), *SIMULATE)
        dem = ["--dem", start / "dem.tif"]
        old_photos = ["--camera", old / "camera.toml", "--orientation", old / "orientation.csv",
                      "--interior", old / "interior", *sorted((old / "photos").glob("*.tif"))]
        for name, date, harvest in (("patches", 1990, ["harvest", *old_photos, "--max-per-photo", 60]),
                                    ("others", 2000, ["harvest-ortho", "--ortho", old / "ortho.tif",
                                                      "--max-per-ortho", 25])):
            database = start / f"{name}.gpkg"
            self.do("patchdb", "create", database, "--crs", "EPSG:32635")
            self.do("patchdb", harvest[0], database, *harvest[1:], *dem, "--date", date)
        self.do("patchdb", "divide", start / "others.gpkg", start / "regions", "--cell-m", 200)
        self.do("patchdb", "retire", start / "others.gpkg", "--id", 1, 2, 3, "--apply")
        block = start / "block.toml"
        block.write_text(block.read_text().replace("[output]\n", '[output]\nformats = ["patb"]\n'))
        shutil.copy(start / "patches.gpkg", start / "before.gpkg")
        self.do("block", block)
        (start / "out").rename(start / "done")
        shutil.move(start / "before.gpkg", start / "patches.gpkg")
        self.write_control_points()
        corners = [[0, 0], [90, 0], [90, 80], [0, 80], [0, 0]]
        (start / "area.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [corners]}))

    def write_control_points(self):
        lines = ["point,x,y,z,sigma_x,sigma_y,sigma_z,photo,col,row"]
        result = json.loads((self.start / "done/new_1_1.exterior.json").read_text())
        for patch in [p for p in result["patches"] if p["pixel"]][:4]:
            numbers = [*patch["ground"], 0.1, 0.1, 0.1]
            lines.append(f"p{patch['id']},{','.join(map(str, numbers))},new_1_1,"
                         f"{','.join(map(str, patch['pixel']))}")
        (self.start / "points.csv").write_text("\n".join(lines) + "\n")

    def commands(self, jobs):
        here = self.here
        scans = [here / f"scans/{photo}.tif" for photo in self.photos]
        patches, others, dem = here / "patches.gpkg", here / "others.gpkg", ["--dem", here / "dem.tif"]
        camera, old = ["--camera", here / "camera.toml"], here / "old"
        of_done = [*camera, "--orientation", here / "done/orientation.csv", "--interior", here / "done"]
        of_old = ["--camera", old / "camera.toml", "--orientation", old / "orientation.csv", "--interior",
                  old / "interior", old / "photos/old_1_1.tif"]
        both = ["patches.gpkg", "others.gpkg"]

        def patchdb(verb, *words, needs=("patches.gpkg",), again=()):
            return Command(list(needs), ["patchdb", verb, *words], again)

        overwrite = ["--overwrite"]
        return {
            "simulate": Command([], ["simulate", "--out", here / "made", "--photos", 1, "--gsd-m", 3,
                                     "--pixel-size-um", 300, "--bare"], overwrite),
            "interior": Command(["scans", "camera.toml"], ["interior", *scans, *camera, "--out",
                                here / "out", "--jobs", jobs, "--micmac"], ["--resume"]),
            "estimate-camera": Command(["done", "camera.toml"], ["interior", "estimate-camera",
                                       here / "done", here / "done", *camera, "--out",
                                       here / "estimated.toml"], overwrite),
            "create": patchdb("create", here / "new.gpkg", "--crs", "EPSG:32635", needs=()),
            "harvest": patchdb("harvest", others, *of_old, *dem, "--max-per-photo", 20,
                               needs=["others.gpkg", "old", "dem.tif"]),
            "harvest-ortho": patchdb("harvest-ortho", patches, "--ortho", old / "ortho.tif", *dem,
                                     "--max-per-ortho", 20, "--dsm", here / "dem.tif",
                                     needs=["patches.gpkg", "old", "dem.tif"]),
            "add-gcp": patchdb("add-gcp", patches, scans[0], "--points", here / "points.csv", *of_done,
                               *dem, needs=["patches.gpkg", "scans", "points.csv", "camera.toml", "done",
                                            "dem.tif"]),
            "merge": patchdb("merge", patches, others, needs=both),
            "update": patchdb("update", patches, others, needs=both),
            "retire": patchdb("retire", patches, "--max-quality", 1, "--apply"),
            "restore": patchdb("restore", others, "--id", 1, 2, "--apply", needs=["others.gpkg"]),
            "prune": patchdb("prune", others, "--id", 2, 3, "--apply", needs=["others.gpkg"]),
            "check": patchdb("check", patches),
            "repair": patchdb("check", patches, "--repair"),
            "compact": patchdb("compact", patches),
            "info": patchdb("info", patches),
            "list": patchdb("list", patches),
            "query": patchdb("query", patches, "--polygon", here / "area.geojson",
                             needs=["patches.gpkg", "area.geojson"]),
            "show": patchdb("show", patches, "--out", here / "chips.png", "--max", 20),
            "stats": patchdb("stats", patches, "--density", here / "density.tif"),
            "export": patchdb("export", patches, "--csv", here / "out.csv", "--geojson",
                              here / "out.geojson", again=overwrite),
            "chips": patchdb("export", others, "--chips", here / "chips", needs=["others.gpkg"],
                             again=overwrite),
            "subset": patchdb("export", patches, "--subset", here / "part.gpkg"),
            "divide": patchdb("divide", patches, here / "divided", "--cell-m", 250),
            "index": patchdb("index", here / "regions", needs=["regions"]),
            "exterior": Command(["scans", "camera.toml", "approx.csv", "approx.prj", "dem.tif",
                                 "patches.gpkg", "done"],
                                ["exterior", *scans, *camera, "--approximations", here / "approx.csv",
                                 *dem, "--patchdb", patches, "--interior", here / "done", "--out",
                                 here / "out", "--jobs", jobs, "--position-sigma-m", 3,
                                 "--attitude-sigma-deg", 0.5, "--learn"], ["--resume"]),
            "block": Command(["scans", "camera.toml", "approx.csv", "approx.prj", "dem.tif",
                              "patches.gpkg", "block.toml"],
                             ["block", here / "block.toml", "--jobs", jobs, "--learn"],
                             ["--resume"]),
            "ortho": Command(["done", "scans", "dem.tif"],
                             ["ortho", here / "done", *scans, *dem, "--out", here / "made", "--gsd-m", 4,
                              "--mosaic", "--jobs", jobs], ["--resume"]),
            "convert": Command(["done", "camera.toml", "scans"],
                               ["convert", here / "done", *camera, "--to",
                                "asp,colmap,metashape,micmac,opensfm,patb,opk", "--out", here / "made",
                                "--images", *scans], overwrite),
            "convert-check": Command(["done"], ["convert", here / "done/exports/patb", "--check"]),
            "convert-from": Command(["done", "camera.toml"],
                                    ["convert", here / "done/exports/patb", "--from", "patb", "--camera",
                                     here / "done/exports/patb/camera.toml", "--to", "opk", "--out",
                                     here / "made"], overwrite),
            "measurements": Command(["done"], ["measurements", here / "done/exports/patb/patb.im",
                                               "--from", "patb", "--sigma", 0.005, "--out",
                                               here / "made"], overwrite),
            "report": Command(["done"], ["report", here / "done"]),
        }

    def do(self, *words):
        done = subprocess.run([self.orient, *map(str, words)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"

    def renew(self, command):
        shutil.rmtree(self.here, ignore_errors=True)
        self.here.mkdir()
        for name in command.needs:
            copy = shutil.copytree if (self.start / name).is_dir() else shutil.copy2
            copy(self.start / name, self.here / name)

    def run(self, words, injector=None, kind="none", at=0, on=False, told=None, places=False,
            cpus=(0,)):
        """`told`: folder in which the injector leaves `calls` and `unflushed`, and `places` if asked."""
        environment = dict(os.environ)
        if injector:
            environment |= {"LD_PRELOAD": str(injector), "ORIENT_FAULT_FOLDER": str(self.here),
                            "ORIENT_FAULT_KIND": kind, "ORIENT_FAULT_AT": str(at),
                            "ORIENT_FAULT_ON": "1" if on else "0"}
        if told:
            environment |= {"ORIENT_FAULT_COUNT": str(told / "calls"),
                            "ORIENT_FAULT_UNFLUSHED": str(told / "unflushed")}
        if places:
            environment["ORIENT_FAULT_PLACES"] = str(told / "places")
        return subprocess.run([self.orient, *words], capture_output=True, text=True, check=False,
                              env=environment, preexec_fn=lambda: os.sched_setaffinity(0, cpus),
                              timeout=LONGEST_S)

    def files(self):
        return {p.relative_to(self.here) for p in self.here.rglob("*") if p.is_file()}

    def result(self):
        """Digests of all files in `here`, by relative path and without times of day."""
        return {name: digest(self.here / name) for name in self.files() if not is_log(name)}


def without_times(text):
    return re.sub(r"\d+(\.\d+)? s\b", "", text)
