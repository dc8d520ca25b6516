#!/usr/bin/env python3
"""CTest `patchdb_kill` (quick) and `patchdb_kill_all` (slow): a patch database survives kill -9.

    kill_test.py ORIENT LEARNER INJECTOR [KILLS [SEED]]

ORIENT: the program; LEARNER: tests/patchdb/learner/main.cpp, which reports attempts as `orient
exterior` does; INJECTOR: tests/faults/injector.cpp, which kills them at the n-th call that writes,
with half of the data in the file; KILLS: number of kills, default 6 (runs that ended before that
call are not counted); SEED: determines at which calls. A database is harvested into, merged into,
updated and compacted, its patches are retired and restored, and it learns. After every kill,
`orient patchdb check` must pass, and everything reported as done must be there.
"""

import collections
import os
import pathlib
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile

import made_up


def count(orient, database):
    out = made_up.run(orient, "patchdb", "info", database)
    values = dict(line.split(None, 1) for line in out.splitlines() if len(line.split()) == 2)
    return {key: int(values[key]) for key in ("patches", "sources", "attempts")}


def harvest_words(folder):
    """Three orthophotos that overlap by half, each with evidence for the others' patches."""
    dem, tiles = made_up.terrain(folder), []
    for number in range(3):
        tiles.append(made_up.orthophoto(folder, number))
    return ["patchdb", "harvest-ortho", "DB", "--ortho", *tiles, "--dem", dem, "--further-views", 2]


def learnt_is_whole(database, printed, attempts_each):
    """Every photo has attempts for all of its patches or for none; reported photos have them."""
    raw = sqlite3.connect(database)
    stored = dict(raw.execute("SELECT photo, count(*) FROM attempts WHERE photo GLOB 'learnt-*' "
                              "GROUP BY photo"))
    raw.close()
    for line in printed.splitlines():
        if line.count(" ") == 1 and line.endswith(tuple("0123456789")):
            attempts_each[line.split()[0]] = int(line.split()[1])
    for photo, attempts in attempts_each.items():
        assert stored.get(photo) == attempts, f"{photo}: {stored.get(photo)} of {attempts} attempts"


class Rounds:
    def __init__(self, orient, learner, injector, folder):
        self.orient, self.learner, self.injector, self.folder = orient, learner, injector, folder
        self.database = folder / "patches.gpkg"
        self.photos = {}  # attempts reported as stored, by photo
        self.killed = collections.Counter()  # by command
        made_up.create(orient, self.database)
        others = [made_up.other(orient, folder, number, sources=6) for number in range(4)]
        made_up.run(orient, "patchdb", "merge", self.database, others[0])
        made_up.give_old_pages(self.database)  # `compact` changes them
        self.start = self.database.read_bytes()
        restore = ["--source", "made-up-0-1.tif", "--apply"]
        self.commands = [["patchdb", "merge", "DB", others[1]], harvest_words(folder), ["LEARN"],
                         ["patchdb", "update", "DB", others[2]], ["patchdb", "merge", "DB", others[3]],
                         ["patchdb", "retire", "DB", *restore], ["patchdb", "restore", "DB", *restore],
                         ["patchdb", "check", "DB", "--repair"], ["patchdb", "compact", "DB"]]
        self.calls = [self.count_calls(words) for words in self.commands]

    def program(self, words, database, first):
        if words == ["LEARN"]:
            return [self.learner, database, str(first), "8"]
        return [self.orient, *[str(database if word == "DB" else word) for word in words]]

    def environment(self, call):
        """Environment of a program that is killed at this call; 0: at none."""
        return {**os.environ, "LD_PRELOAD": self.injector, "ORIENT_FAULT_FOLDER": str(self.folder),
                "ORIENT_FAULT_KIND": "kill", "ORIENT_FAULT_AT": str(call),
                "ORIENT_FAULT_COUNT": str(self.folder / "count")}

    def count_calls(self, words):
        copy = self.folder / "counted.gpkg"
        copy.write_bytes(self.start)
        subprocess.run(self.program(words, copy, 0), check=True, capture_output=True, timeout=300,
                       env=self.environment(0))
        copy.unlink()
        return int(dict(map(str.split, (self.folder / "count").read_text().splitlines()))["kill"])

    def kill_one(self, round_, done):
        number = round_ % len(self.commands)
        words = self.commands[number]
        call = random.randint(1, self.calls[number])
        child = subprocess.run(self.program(words, self.database, 8 * round_), capture_output=True,
                               text=True, timeout=300, check=False, env=self.environment(call))
        printed = child.stdout
        name = "learn" if words == ["LEARN"] else words[1]
        self.killed[name] += child.returncode == -signal.SIGKILL
        assert child.returncode in (0, -signal.SIGKILL), f"{words}, call {call}: {child.stderr}"
        made_up.run(self.orient, "patchdb", "check", self.database)
        if words == ["LEARN"]:
            learnt_is_whole(self.database, printed, self.photos)
        now = count(self.orient, self.database)
        for key, value in done.items():
            assert now[key] >= value, f"round {round_}, {words}: {key} fell to {now[key]}"
        return now

    def begin_anew(self):
        for leftover in self.folder.glob("patches.gpkg-*"):
            leftover.unlink()
        self.database.write_bytes(self.start)
        self.photos = {}
        return count(self.orient, self.database)

    def finish(self):
        """Repeating interrupted commands completes them; a second merge changes nothing."""
        for words in self.commands[:5]:
            subprocess.run(self.program(words, self.database, 0), check=True, capture_output=True,
                           timeout=300)
        made_up.run(self.orient, "patchdb", "check", self.database)
        merge = [self.orient, "patchdb", "merge", self.database, self.commands[0][3]]
        subprocess.run(merge, check=True, capture_output=True, timeout=300)
        whole = count(self.orient, self.database)
        raw = sqlite3.connect(self.database)
        joined = raw.execute("SELECT count(*) FROM patches WHERE views > 1").fetchone()[0]
        unharvested = raw.execute("SELECT count(*) FROM sources WHERE NOT harvested").fetchone()[0]
        raw.close()
        assert joined > 50, f"only {joined} patches were joined"
        assert unharvested == 0, f"{unharvested} sources of evidence are not harvested"
        subprocess.run(merge, check=True, capture_output=True, timeout=300)
        assert count(self.orient, self.database) == whole, "a second merge changed something"
        return whole


def main(orient, learner, injector, kills, seed):
    random.seed(seed)
    with tempfile.TemporaryDirectory() as name:
        rounds = Rounds(orient, learner, injector, pathlib.Path(name))
        done = count(orient, rounds.database)
        round_ = 0
        while rounds.killed.total() < kills:
            done = rounds.kill_one(round_, done)
            round_ += 1
            print(f"\r{rounds.killed.total()} killed", end="", file=sys.stderr, flush=True)
            assert round_ < 4 * kills + 20, "too few kills hit a running program"
            if round_ % 20 == 0:  # starts again, so that there is something to do
                done = rounds.begin_anew()
        whole = rounds.finish()
        print(f"{rounds.killed.total()} of {round_} programs killed in the middle: "
              f"{', '.join(f'{count} {name}' for name, count in rounds.killed.most_common())}; "
              f"{whole['patches']} patches are whole")


if __name__ == "__main__":
    main(*sys.argv[1:4], int(sys.argv[4]) if len(sys.argv) > 4 else 6,
         int(sys.argv[5]) if len(sys.argv) > 5 else 20250417)
