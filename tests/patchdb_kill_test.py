#!/usr/bin/env python3
"""CTest `patchdb_kill` (slow): a patch database survives kill -9 at any moment.

    patchdb_kill_test.py ORIENT [KILLS]   ORIENT: the program; KILLS: 200 unless told

A database is grown, merged into, updated and pruned by the program itself, which is killed at random
moments. After every kill `orient patchdb check` must pass and everything reported done before must be
there. Learning goes through the same transaction as all of these; its rows are checked with the
attempts that the merged databases bring along.
"""

import pathlib
import random
import subprocess
import sys
import tempfile
import time

import patchdb_made_up


def count(orient, database):
    out = patchdb_made_up.run(orient, "patchdb", "info", database)
    values = dict(line.split(None, 1) for line in out.splitlines() if len(line.split()) == 2)
    return {key: int(values[key]) for key in ("patches", "sources", "attempts")}


def duration_of(orient, words, folder, database):
    copy = folder / "timed.gpkg"
    copy.write_bytes(database.read_bytes())
    start = time.monotonic()
    patchdb_made_up.run(orient, *[copy if word == "DB" else word for word in words])
    copy.unlink()
    return time.monotonic() - start


def main(orient, kills):
    random.seed(20250417)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        database = folder / "patches.gpkg"
        patchdb_made_up.create(orient, database)
        others = [patchdb_made_up.other(orient, folder, number) for number in range(4)]
        patchdb_made_up.run(orient, "patchdb", "merge", database, others[0])
        commands = [["patchdb", "merge", "DB", others[1]], ["patchdb", "update", "DB", others[2]],
                    ["patchdb", "merge", "DB", others[3]],
                    ["patchdb", "retire", "DB", "--source", "made-up-0-1.tif", "--apply"],
                    ["patchdb", "restore", "DB", "--source", "made-up-0-1.tif", "--apply"],
                    ["patchdb", "check", "DB", "--repair"], ["patchdb", "compact", "DB"]]
        times = [duration_of(orient, words, folder, database) for words in commands]
        killed = 0
        done = count(orient, database)
        start = database.read_bytes()
        for round_ in range(kills):
            number = round_ % len(commands)
            words = [database if word == "DB" else word for word in commands[number]]
            child = subprocess.Popen([orient, *words], stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL)
            time.sleep(random.uniform(0, 1.1) * times[number])
            child.kill()
            killed += child.wait() != 0
            patchdb_made_up.run(orient, "patchdb", "check", database)
            now = count(orient, database)
            for key, value in done.items():
                assert now[key] >= value, f"round {round_}, {words[1]}: {key} fell to {now[key]}"
            done = now
            if round_ % 20 == 19:  # from the beginning, so that there is something to do
                for leftover in folder.glob("patches.gpkg-*"):
                    leftover.unlink()
                database.write_bytes(start)
                done = count(orient, database)
        # What was interrupted is finished by doing it again.
        for words in commands[:3]:
            patchdb_made_up.run(orient, *[database if word == "DB" else word for word in words])
        patchdb_made_up.run(orient, "patchdb", "check", database)
        print(f"{kills} rounds, {killed} of them killed in the middle; "
              f"{count(orient, database)['patches']} patches are whole")
        assert killed >= kills // 3, "too few kills hit a running program"


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 200)
