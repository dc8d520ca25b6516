#!/usr/bin/env python3
"""CTest `block_kill` (slow): a block survives kill -9 at any moment.

    block_kill_test.py ORIENT [KILLS [SEED]]

ORIENT: the program; KILLS: 50 unless told, of programs in the middle of their work (those that ended
before are not counted); SEED: another one kills at other moments. A small simulated block is oriented
undisturbed, with quicklook, exports and a patch database that learns. Then it is oriented again and
again: each run is killed at random moments and started anew until it ends by itself. What is in the
output folder and in the patch database must be the same to the last byte, times of day aside.
"""

import hashlib
import pathlib
import random
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time

SIMULATE = ["--photos", "4", "--gsd-m", "0.75", "--pixel-size-um", "75", "--bare",
            "--position-error-m", "3", "--attitude-error-deg", "0.5"]
# When one of these appears, changes or goes, a stage has just begun or ended.
MILESTONES = ["stages/unfinished", "stages/exterior/not_yet_learnt", "stages/exterior/orientation.csv",
              "stages/neighbours", "stages/ties", "orientation.csv", "block.json", "block.gpkg",
              "quicklook.png", "seams.png", "report.html", "exports"]


def run(orient, *words):
    done = subprocess.run([orient, *map(str, words)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
    return done.stdout


def tables(path):
    """All rows of a GeoPackage, but for the times at which they were written and the numbers of
    attempts: what a killed run has told already is told again and replaces it."""
    raw = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    rows = []
    left_out = {"last_change", "recorded"}
    for (name,) in raw.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name"):
        columns = [column[1] for column in raw.execute(f'PRAGMA table_info("{name}")')]
        if name == "sqlite_sequence":
            continue
        kept = [c for c in columns if c not in left_out and (name, c) != ("attempts", "id")]
        chosen = ", ".join(f'"{column}"' for column in kept) or "1"
        found = raw.execute(f'SELECT {chosen} FROM "{name}"').fetchall()
        rows.append((name, kept, sorted(found, key=repr)))
    raw.close()
    return rows


def digest(path):
    content = repr(tables(path)).encode() if path.suffix == ".gpkg" else path.read_bytes()
    return hashlib.sha256(content).hexdigest()


def result(folder):
    """What is said of the block and of its patches, by file."""
    files = {p.relative_to(folder): digest(p) for p in sorted((folder / "out").rglob("*")) if p.is_file()}
    files[pathlib.Path("patches.gpkg")] = digest(folder / "patches.gpkg")
    return files


def differences(folder, expected, reference):
    now = result(folder)
    lines = [f"{name}: {'absent' if name not in now else 'not there before' if name not in expected else 'differs'}"
             for name in sorted(now.keys() | expected.keys()) if now.get(name) != expected.get(name)]
    for name in now.keys() & expected.keys():
        if now[name] == expected[name] or name.suffix != ".gpkg":
            continue
        here, there = tables(folder / name), tables(reference / name)
        lines += [f"  table {a[0]}: {len(a[2])} and {len(b[2])} rows"
                  for a, b in zip(here, there) if a != b]
    return lines


class Killer:
    def __init__(self, orient, folder, chance):
        self.orient, self.folder, self.chance = orient, folder, chance
        self.kept = folder.parent / "kept"
        self.counts = {}  # kills by the stage that they fell into

    def stage(self):
        out = self.folder / "out"
        names = ["stages/unfinished", *[p for p in MILESTONES[1:] if (out / p).exists()]]
        return names[-1]

    def finished(self):
        out = self.folder / "out"
        return (out / "orientation.csv").exists() and not (out / "stages/unfinished").exists()

    def state(self):
        state = []
        for name in MILESTONES:
            try:
                state.append((self.folder / "out" / name).stat().st_mtime_ns)
            except OSError:
                state.append(None)
        return state

    def start(self):
        words = [self.orient, "block", str(self.folder / "block.toml"), "--quicklook", "--jobs", "2"]
        return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def wait(self, process, seconds):
        """Half of the kills come at any moment, half shortly after a milestone."""
        end = time.monotonic() + seconds
        milestones = self.chance.randint(1, 12) if self.chance.random() < 0.5 else None
        before = self.state()
        while process.poll() is None and time.monotonic() < end:
            time.sleep(0.002)
            if milestones is None:
                continue
            now = self.state()
            milestones -= sum(a != b for a, b in zip(before, now))
            before = now
            if milestones <= 0:
                time.sleep(self.chance.uniform(0, 0.15))
                break

    def kill_once(self, seconds):
        """Whether the program was killed; otherwise it has ended by itself, and well."""
        process = self.start()
        self.wait(process, self.chance.uniform(0, seconds))
        if process.poll() is None:
            stage = self.stage()
            process.send_signal(signal.SIGKILL)
            process.communicate()
            if self.finished():  # it had only its farewell to say
                return False
            self.counts[stage] = self.counts.get(stage, 0) + 1
            return True
        _, errors = process.communicate()
        assert process.returncode == 0, errors
        return False

    def fresh(self):
        shutil.rmtree(self.folder / "out", ignore_errors=True)
        for suffix in ("-wal", "-shm", "-journal"):
            (self.folder / f"patches.gpkg{suffix}").unlink(missing_ok=True)
        shutil.copy(self.kept / "patches.gpkg", self.folder / "patches.gpkg")


def prepare(orient, folder):
    run(orient, "simulate", "--out", folder, *SIMULATE)
    run(orient, "patchdb", "create", folder / "patches.gpkg", "--crs", "EPSG:32635")
    run(orient, "patchdb", "harvest", folder / "patches.gpkg", "--camera", folder / "old/camera.toml",
        "--orientation", folder / "old/orientation.csv", "--dem", folder / "dem.tif",
        "--max-per-photo", 200, *sorted((folder / "old/photos").glob("*.tif")))
    block = folder / "block.toml"
    block.write_text(block.read_text().replace("[output]\n", '[output]\nformats = ["patb", "colmap"]\n'))
    (folder.parent / "kept").mkdir()
    shutil.copy(folder / "patches.gpkg", folder.parent / "kept/patches.gpkg")


def main():
    orient = sys.argv[1]
    kills = int(sys.argv[2]) if len(sys.argv) > 2 else 50
    chance = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "block"
        prepare(orient, folder)
        killer = Killer(orient, folder, chance)
        began = time.monotonic()
        run(orient, "block", folder / "block.toml", "--quicklook", "--jobs", "2")
        seconds = time.monotonic() - began
        expected = result(folder)
        reference = pathlib.Path(temporary) / "reference"
        shutil.copytree(folder, reference)
        killed = rounds = 0
        wrong = []
        while killed < kills:
            killer.fresh()
            while killed < kills and killer.kill_once(seconds):
                killed += 1
            if killed >= kills:
                run(orient, "block", folder / "block.toml", "--quicklook", "--resume")
            rounds += 1
            found = differences(folder, expected, reference)
            if found:
                print(f"round {rounds}, after {killed} kills:", *found, sep="\n  ", flush=True)
                wrong.append(rounds)
        print(f"{killed} kills in {rounds} rounds, {seconds:.1f} s undisturbed; killed in:")
        for stage, count in sorted(killer.counts.items()):
            print(f"  {stage}: {count}")
        if wrong:
            sys.exit(f"{len(wrong)} of {rounds} rounds ended otherwise than the undisturbed run")


if __name__ == "__main__":
    main()
