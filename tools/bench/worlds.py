#!/usr/bin/env python3
"""Success rate, precision and speed of orienting photos from increasingly poor approximations.

    worlds.py PROGRAM FOLDER [--worlds parcels turned mountain] [--harvests default 60 60+views 30]
              [--starts 1m 10m 30m 100m] [--kappa known unknown] [--draws 5] [--seed 1] [--jobs 0]
              [--elsewhere] [--finer 1] [--grain 0] [--again]
    worlds.py --self-test        Tests the geometry: on a synthetic photo, on the worlds if present.

PROGRAM is a path to `orient`. The worlds, blocks from another simulator, are read from
$ORIENT_SHARED_DATA/worlds (default: ../shared/data/worlds beside the project). FOLDER keeps, for
each world, the interior orientations and one patch database per harvest, made once, by the first
program used (to have them made again, delete FOLDER/WORLD and give --again). FOLDER/worlds.json
keeps all runs; runs of the same program are not repeated without --again. Ctrl-C loses only the
current run.

A start is the sigma of Gaussian errors added to the true poses: 1m with 1', 10m with 3 degrees, 30m
and 100m with 10 degrees. The random numbers of a draw are the same for all starts, scaled, and for
all harvests. Unknown kappa is instead drawn from the full circle, and run with --kappa-sigma-deg
180. With --elsewhere (parcels and turned only), the patches are those of the other one of the two,
whose ground lies at the same coordinates and looks different: no photo can be oriented, and the
time is that of searching in vain. With --finer N, the photos are enlarged N times (gdal_translate,
cubic), as if they had been scanned with pixels so much smaller than those of the patches. With
--grain N, Gaussian noise of N grey values is added to every pixel, as on very grainy film.

RMS px: the RMS distance over the whole frame, in scan pixels, between the projections of ground
points on the DEM by the estimated film transform and pose and their true positions; the table has
its median over the photos that are ok. Photos with status ok and more than 1 px are `wrong`. Over
sigma: the normalised errors, i.e. these errors of photos that are ok or weak over those expected
from their covariances, RMS; 1 if the covariances are realistic. Processor seconds are those of
`orient exterior`, divided by its photos; memory is its peak, which grows with --jobs. The finding
is the most frequent one that made photos fail (or weak, if none failed). worlds.json has every
photo, and its numbers of patches: `visible` are those searched for, `correlating` those matched or
rejected, `matched` those used.
"""

import argparse
import collections
import hashlib
import itertools
import json
import math
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import sys

import numpy as np
from osgeo import gdal

sys.dont_write_bytecode = True  # beside the sources
from result_jobs import CONSOLE, Job, JobFailed, harvest, moved_table, shared_data  # noqa: E402
from world_truth import Truth, self_test  # noqa: E402

gdal.UseExceptions()

WORLDS = ["parcels", "turned", "mountain"]
HARVESTS = {"default": [], "60": ["--max-per-photo", 60], "30": ["--max-per-photo", 30],
            "60+views": ["--max-per-photo", 60, "--further-views", 3]}
STARTS = {"1m": (1, 1 / 60), "10m": (10, 3), "30m": (30, 10), "100m": (100, 10)}  # best first
KAPPAS = ["known", "unknown"]
ELSEWHERE = {"parcels": "turned", "turned": "parcels"}  # of another look, at the same place
WRONG_PX = 1.0
RECORD = "worlds.json"
TRUTH = "truth.csv"  # true poses of a world's photos, for exterior_matches
# The key of a run; program: a digest.
Run = collections.namedtuple("Run", "program world harvest start kappa seed draw elsewhere finer"
                             " grain", defaults=[False, 1, 0])


class Change(collections.namedtuple("Change", "finer grain", defaults=[1, 0])):
    """How scans differ from the world's own; as text, the suffix of what is made from them."""

    def any(self):
        return self != Change()

    def __str__(self):
        return (f"_{self.finer}" if self.finer > 1 else "") + (f"_grain_{self.grain}" if self.grain
                                                               else "")


class World:
    def __init__(self, place, home):
        self.place, self.home, self.name, self.truth = place, home, place.name, Truth(place)

    def scans(self, change):
        return self.home / f"scans{change}" if change.any() else self.place / "scans"

    def interior(self, change):
        return self.home / f"interior{change}"

    def change_scans(self, change, out):
        (self.home / out).mkdir()
        for scan in sorted((self.place / "scans").glob("*.tif")):
            changed = self.home / out / scan.name
            subprocess.run(["gdal_translate", "-q", "-r", "cubic", "-outsize",
                            f"{change.finer}00%", f"{change.finer}00%", "-co", "TILED=YES", scan,
                            changed], check=True)
            if change.grain:
                add_grain(changed, change.grain)

    def prepare(self, program, harvests, change):
        """Makes missing interior orientations and patch databases; yields their names."""
        place, home, old = self.place, self.home, sorted((self.place / "old_scans").glob("*.tif"))
        home.mkdir(parents=True, exist_ok=True)
        poses = {photo: [of["eo"][name] for name in ("x", "y", "z", "omega", "phi", "kappa")]
                 for photo, of in self.truth.photos.items()}
        (home / TRUTH).write_text(self.table(lambda photo, _: poses[photo]), encoding="utf-8")
        shutil.copyfile(place / "approx_coarse.prj", home / pathlib.Path(TRUTH).with_suffix(".prj"))
        job, works = Job(program, home, place), {}
        for kind in ("old_", ""):
            scan = next(iter(self.truth.all[f"{kind}photos"].values()))
            camera = place / ("camera_old.toml" if kind else "camera.toml")
            works[f"{kind}interior"] = lambda out, kind=kind, scan=scan, camera=camera: job.run(
                "interior", *sorted((place / f"{kind}scans").glob("*.tif")), "--camera", camera,
                "--orientation", scan["d4"], "--pixel-size-um", scan["pixel_size_um"],
                "--out", out)
        if change.any():
            scan = next(iter(self.truth.photos.values()))
            works[self.scans(change).name] = lambda out: self.change_scans(change, out)
            works[self.interior(change).name] = lambda out: job.run(
                "interior", *sorted(self.scans(change).glob("*.tif")), "--camera",
                place / "camera.toml", "--orientation", scan["d4"], "--pixel-size-um",
                scan["pixel_size_um"] / change.finer, "--out", out)
        for kind in harvests:
            works[f"patches_{kind}.gpkg"] = lambda out, kind=kind: harvest(
                job, out, f"EPSG:{self.truth.all['epsg']}", *old, "--interior", "old_interior",
                "--camera", place / "camera_old.toml", "--orientation",
                place / "old_orientation.csv", "--dem", place / "dem.tif", *HARVESTS[kind])
        for name, work in works.items():
            if (home / name).exists():
                continue
            for rest in home.glob("unfinished*"):
                shutil.rmtree(rest) if rest.is_dir() else rest.unlink()
            print(f"{self.name}: {name}", file=sys.stderr, flush=True)
            unfinished = f"unfinished{pathlib.Path(name).suffix}"
            work(unfinished)
            os.replace(home / unfinished, home / name)
            yield f"{self.name}/{name}"

    def approximations(self, run):
        def drawn(photo, _):
            chance = random.Random(f"{run.seed} {run.draw} {self.name} {photo}")
            truth, (position_m, attitude_deg) = self.truth.photos[photo]["eo"], STARTS[run.start]
            row = [truth[of] + position_m * chance.gauss(0, 1) for of in "xyz"]
            row += [truth[of] + attitude_deg * chance.gauss(0, 1)
                    for of in ("omega", "phi", "kappa")]
            anywhere = chance.uniform(-180, 180)
            return row[:5] + [anywhere] if run.kappa == "unknown" else row
        return self.table(drawn)

    def table(self, elements):
        """A table of orientations, made by `moved_table`."""
        return moved_table((self.place / "approx_coarse.csv").read_text(encoding="utf-8"), elements)

    def judged(self, photo, folder, change):
        result = json.loads((folder / f"{photo}.exterior.json").read_text(encoding="utf-8"))
        rms_px = stated_px = None
        if result.get("pose") and result["status"] != "failed":
            film = self.interior(change) / f"{photo}.interior.json"
            film = json.loads(film.read_text(encoding="utf-8"))["photo_from_pixel"]
            # For pixels of the scan as it was.
            film = [[change.finer * row[0], change.finer * row[1], row[2]] for row in film]
            rms_px = self.truth.rms_px(photo, result["pose"], film)
            stated_px = self.truth.stated_px(photo, result["pose"], result["covariance"], film)
        states = collections.Counter(patch["state"] for patch in result.get("patches", []))
        return {"status": result["status"], "rms_px": rms_px, "stated_px": stated_px,
                "wrong": result["status"] == "ok" and rms_px > WRONG_PX,
                "visible": sum(states.values()) - states["not_visible"],
                "correlating": states["matched"] + states["rejected"], "matched": states["matched"],
                "findings": [finding["code"] for finding in result["findings"]
                             if finding["at_best"] == result["status"] != "ok"]}

    def run(self, program, run, jobs):
        """One `orient exterior` of all photos; run: a Run."""
        change = Change(run.finer, run.grain)
        folder = self.home / "exterior" / "_".join([run.program[:8], *map(str, run[2:])])
        folder.mkdir(parents=True, exist_ok=True)
        for rest in folder.glob("*.exterior.json"):
            rest.unlink()
        (folder / "approx.csv").write_text(self.approximations(run), encoding="utf-8")
        shutil.copyfile(self.place / "approx_coarse.prj", folder / "approx.prj")
        position_m, attitude_deg = STARTS[run.start]
        patches_of = ELSEWHERE[self.name] if run.elsewhere else self.name
        line = [program, "exterior", *sorted(self.scans(change).glob("*.tif")),
                "--camera", self.place / "camera.toml", "--dem", self.place / "dem.tif",
                "--approximations", folder / "approx.csv", "--interior", self.interior(change),
                "--patchdb", self.home.parent / patches_of / f"patches_{run.harvest}.gpkg",
                "--no-feedback",
                "--position-sigma-m", position_m, "--attitude-sigma-deg", attitude_deg,
                "--out", folder, "--overwrite", "--jobs", jobs]
        line += ["--kappa-sigma-deg", 180] if run.kappa == "unknown" else []
        code, used = measured(line, folder / CONSOLE)
        if code in (1, 2):  # usage or input error: not a benchmark result
            raise JobFailed(f"orient exterior: exit code {code}, see {folder / CONSOLE}")
        died = {"status": "failed", "rms_px": None, "stated_px": None, "wrong": False,
                "visible": 0, "correlating": 0, "matched": 0, "findings": [f"exit_code_{code}"]}
        names = self.truth.photos
        return {**run._asdict(), "jobs": jobs, "exit_code": code,
                "seconds_per_photo": (used.ru_utime + used.ru_stime) / len(names),
                "memory_mb": used.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10),
                "photos": {photo: self.judged(photo, folder, change) if code in (0, 3) else died
                           for photo in names}}



def add_grain(path, sigma):
    """Adds Gaussian noise, in grey values, to every pixel of a scan; the same to each scan."""
    scan = gdal.OpenEx(str(path), gdal.OF_RASTER | gdal.OF_UPDATE)
    for band in range(1, scan.RasterCount + 1):
        grey = scan.GetRasterBand(band).ReadAsArray()
        noise = np.random.default_rng(band).normal(0, sigma, grey.shape)
        scan.GetRasterBand(band).WriteArray(np.clip(np.rint(grey + noise), 0, 255).astype(np.uint8))


def measured(line, console):
    """Runs a program; returns its exit code and resource usage."""
    with open(console, "w", encoding="utf-8") as file:
        child = subprocess.Popen([str(word) for word in line], stdout=file, stderr=file)
        try:
            _, state, used = os.wait4(child.pid, 0)
        except KeyboardInterrupt:
            child.kill()
            child.wait()
            raise
    child.returncode = os.waitstatus_to_exitcode(state)
    return child.returncode, used


class Record:
    """FOLDER/worlds.json: `runs`, and by which program other parts of FOLDER were `made`."""

    def __init__(self, path):
        self.path, self.made, self.runs = path, {}, {}
        if path.exists():
            told = json.loads(path.read_text(encoding="utf-8"))
            self.made = told["made"]
            self.runs = {Run(**{of: run[of] for of in Run._fields if of in run}): run
                         for run in told["runs"]}

    def write(self):
        text = json.dumps({"made": self.made, "runs": list(self.runs.values())}, indent=1)
        self.path.with_suffix(".new").write_text(text + "\n", encoding="utf-8")
        os.replace(self.path.with_suffix(".new"), self.path)


def photos_of(runs):
    return [photo for run in runs for photo in run["photos"].values()]


def rate_of_ok(runs):
    return statistics.fmean(photo["status"] == "ok" for photo in photos_of(runs))


def violations(groups):
    """Cases where a better start or a known kappa made fewer photos ok, over common draws."""
    found = []
    for (better, runs), (poorer, others) in itertools.permutations(groups.items(), 2):
        differs = [i for i, (a, b) in enumerate(zip(better, poorer)) if a != b]
        ranks = [(list(STARTS).index(key[2]), KAPPAS.index(key[3])) for key in (better, poorer)]
        draws = {run["draw"] for run in runs} & {run["draw"] for run in others}
        if differs in ([2], [3]) and ranks[0] < ranks[1] and draws:
            rates = [rate_of_ok([run for run in part if run["draw"] in draws])
                     for part in (runs, others)]
            if rates[0] < rates[1]:
                found.append(f"  {' '.join(better)} {rates[0]:.0%},"
                             f" {' '.join(poorer)} {rates[1]:.0%}")
    return found


def over_sigma(photos):
    """RMS of errors over stated sigmas; older records have no sigmas."""
    ratios = [photo["rms_px"] / photo["stated_px"] for photo in photos if photo.get("stated_px")]
    return f"{math.sqrt(statistics.fmean(r * r for r in ratios)):.2f}" if ratios else "-"


def report(groups):
    """groups: the runs of each (world, harvest, start, kappa)."""
    print(f"{'world':9}{'harvest':9}{'start':6}{'kappa':8}|{'photos':>7}{'ok':>5}{'weak':>5}"
          f"{'failed':>7}{'wrong':>6}{'RMS px':>8}{'over sigma':>11}{'s median':>9}{'s max':>7}"
          f"{'MB':>6}  finding")
    for key, runs in groups.items():
        photos, seconds = photos_of(runs), [run["seconds_per_photo"] for run in runs]
        count = collections.Counter(photo["status"] for photo in photos)
        rms = [photo["rms_px"] for photo in photos if photo["status"] == "ok"]
        worst = "failed" if count["failed"] else "weak"
        codes = collections.Counter(code for photo in photos if photo["status"] == worst
                                    for code in photo["findings"]).most_common(1)
        print("{:9}{:9}{:6}{:8}|".format(*key) + f"{len(photos):7}{count['ok']:5}{count['weak']:5}"
              f"{count['failed']:7}{sum(photo['wrong'] for photo in photos):6}"
              f"{f'{statistics.median(rms):.2f}' if rms else '-':>8}"
              f"{over_sigma(photos):>11}{statistics.median(seconds):9.1f}{max(seconds):7.1f}"
              f"{max(run['memory_mb'] for run in runs):6.0f}"
              + "".join(f"  {code} ({times})" for code, times in codes))
    runs = [run for part in groups.values() for run in part]
    wrong, found = sum(photo["wrong"] for photo in photos_of(runs)), violations(groups)
    print(f"rate of ok: {rate_of_ok(runs):.1%} of {len(photos_of(runs))} photos; wrong: {wrong}; "
          f"errors over sigmas: {over_sigma(photos_of(runs))}\n"
          "a better start never lowers the rate:", f"{len(found)} violations" if found else "true")
    print("".join(f"{line}\n" for line in found), end="")


def work(told, program, folder, wanted, record):
    """Does all runs that are wanted and not yet done."""
    data, worlds = shared_data() / "worlds", {}
    digest = wanted[0].program
    sources = [ELSEWHERE[name] for name in told.worlds] if told.elsewhere else []
    for name in dict.fromkeys([*told.worlds, *sources]):
        worlds[name] = World(data / name, folder / name)
        change = Change(told.finer, told.grain) if name in told.worlds else Change()
        for made in worlds[name].prepare(program, dict.fromkeys(told.harvests), change):
            record.made[made] = digest
            record.write()
    others = [made for made, by in record.made.items()
              if by != digest and made.split("/")[0] in worlds]
    if others:
        print(f"made by another program: {', '.join(others)}", file=sys.stderr)
    for number, run in enumerate(wanted, 1):
        if run in record.runs and not told.again:
            continue
        record.runs[run] = worlds[run.world].run(program, run, told.jobs)
        record.write()
        states = [photo["status"] for photo in record.runs[run]["photos"].values()]
        print(f"{number} of {len(wanted)}: {' '.join(map(str, run[1:5]))} draw {run.draw}:"
              f" {' '.join(states)}", file=sys.stderr, flush=True)


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test(shared_data() / "worlds")
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    for name, choices in (("worlds", WORLDS), ("harvests", HARVESTS), ("starts", STARTS),
                          ("kappa", KAPPAS)):
        parser.add_argument(f"--{name}", nargs="+", choices=choices, default=list(choices))
    for name, value in (("draws", 5), ("seed", 1), ("jobs", 0), ("finer", 1),
                        ("grain", 0)):
        parser.add_argument(f"--{name}", type=int, default=value)
    parser.add_argument("--elsewhere", action="store_true")
    parser.add_argument("--again", action="store_true")
    told = parser.parse_args(arguments)
    program, folder, data = told.program.resolve(), told.folder.resolve(), shared_data() / "worlds"
    if not os.access(program, os.X_OK) or not program.is_file():
        sys.exit(f"{program}: no such program")
    if told.elsewhere:
        told.worlds = [name for name in told.worlds if name in ELSEWHERE]
    needed = told.worlds + [ELSEWHERE[name] for name in told.worlds if told.elsewhere]
    absent = [name for name in needed if not (data / name / "truth.json").is_file()]
    if absent:
        sys.exit(f"no {', '.join(absent)} in {data}: set ORIENT_SHARED_DATA to the shared data")
    if told.draws < 1 or told.finer < 1 or told.grain < 0:
        sys.exit("--draws, --finer: at least 1; --grain: not negative")
    digest = hashlib.sha256(program.read_bytes()).hexdigest()
    record = Record(folder / RECORD)
    parts = [dict.fromkeys(part) for part in (told.worlds, told.harvests, told.starts, told.kappa)]
    wanted = [Run(digest, *key, told.seed, draw, told.elsewhere, told.finer, told.grain)
              for draw in range(1, told.draws + 1) for key in itertools.product(*parts)]
    stopped = None
    try:
        work(told, program, folder, wanted, record)
    except KeyboardInterrupt:
        stopped = "interrupted: the same command continues"
    except JobFailed as failure:
        stopped = str(failure)
    groups = {key: [record.runs[run] for run in wanted if run[1:5] == key and run in record.runs]
              for key in itertools.product(*parts)}
    groups = {key: runs for key, runs in groups.items() if runs}
    if groups:
        report(groups)
    return stopped


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
