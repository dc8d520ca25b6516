#!/usr/bin/env python3
"""CTest `patchdb_writers` (quick) and `patchdb_writers_all` (slow): two writers and four readers at
once, without errors or losses; of four that create the same database, exactly one succeeds.

    writers_test.py ORIENT [TURNS]   TURNS: commands of each writer, default 3 (each at least once)
"""

import pathlib
import subprocess
import sys
import tempfile
import threading

import made_up


def race(orient, folder):
    """Four programs create the same database at once."""
    for turn in range(3):
        database = folder / f"raced{turn}.gpkg"
        words = [orient, "patchdb", "create", database, "--crs", "EPSG:32635"]
        runs = [subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                for _ in range(4)]
        codes = sorted((run.communicate()[1], run.returncode)[1] for run in runs)
        assert codes == [0, 2, 2, 2], f"exit codes {codes}"
        made_up.run(orient, "patchdb", "check", database)
        left = [path.name for path in folder.iterdir() if path.name.startswith(f"raced{turn}.gpkg.")]
        assert not left, f"{left} were left"


def main(orient, turns):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        database = folder / "patches.gpkg"
        made_up.create(orient, database)
        others = [made_up.other(orient, folder, number, sources=3) for number in range(4)]
        made_up.run(orient, "patchdb", "merge", database, others[0])
        race(orient, folder)
        errors, runs, writing = [], [0, 0], [2]

        def work(kind, commands):
            turn = 0
            while (turn < turns if kind == 0 else writing[0] > 0) and not errors:
                words = commands[turn % len(commands)]
                done = subprocess.run([orient, "patchdb", *map(str, words)], capture_output=True,
                                      text=True, check=False, timeout=120)
                if done.returncode != 0:
                    errors.append(f"{words}: exit {done.returncode}: {done.stderr}")
                runs[kind] += 1
                turn += 1
            writing[0] -= kind == 0

        writers = [[["merge", database, others[1]],
                    ["retire", database, "--source", "made-up-0-1.tif", "--apply"]],
                   [["restore", database, "--source", "made-up-0-1.tif", "--apply"],
                    ["merge", database, others[2]], ["merge", database, others[3]]]]
        readers = [[["list", database]], [["stats", database]], [["check", database, "--quick"]],
                   [["query", database, "--box", 499000, 4999000, 502000, 5002000]]]
        threads = [threading.Thread(target=work, args=(0, commands)) for commands in writers]
        threads += [threading.Thread(target=work, args=(1, commands)) for commands in readers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert not errors, "\n".join(errors)
        made_up.run(orient, "patchdb", "check", database)
        for other in others:  # nothing that was merged is missing
            out = made_up.run(orient, "patchdb", "merge", database, other)
            assert out.startswith("0 patches of 0 new sources added"), out
        print(f"{runs[0]} writing and {runs[1]} reading runs, no error")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3)
