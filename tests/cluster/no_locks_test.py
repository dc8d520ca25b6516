#!/usr/bin/env python3
"""CTest `parts_without_locks`: on a file system without locks, parallel parts, each run by two
processes at once, still give the same block as a single run, byte for byte.

    no_locks_test.py ORIENT INJECTOR
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from simulated_block import complaints_about_difference, make_block, run

PARTS = 4  # each by two processes


def side_by_side(orient, block, stage, environment):
    words = [str(orient), "block", str(block), "--stage", stage, "--jobs", "1", "--part"]
    runs = [subprocess.Popen(words + [f"{part}/{PARTS}"], env=environment, text=True,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            for part in range(1, PARTS + 1) for _ in range(2)]
    for one in runs:
        said = one.communicate()[0]
        if one.returncode != 0:
            sys.exit(f"{stage}: exit code {one.returncode}\n{said}")


def main(orient, injector):
    orient = pathlib.Path(orient).resolve()
    environment = {**os.environ, "LD_PRELOAD": injector, "ORIENT_FAULT_NO_LOCKS": "1"}
    with tempfile.TemporaryDirectory() as temporary:
        one, many = pathlib.Path(temporary) / "one", pathlib.Path(temporary) / "many"
        make_block(orient, one, 4, "--pixel-size-um", 60, "--gsd-m", 0.8)
        shutil.copytree(one, many)
        run(orient, "block", one / "block.toml", codes=(0, 3))
        block = many / "block.toml"
        side_by_side(orient, block, "interior", environment)
        run("env", f"LD_PRELOAD={injector}", "ORIENT_FAULT_NO_LOCKS=1", orient, "block", block,
            "--stage", "interior")
        side_by_side(orient, block, "exterior", environment)
        run(orient, "block", block, codes=(0, 3))
        other = complaints_about_difference(one / "out", many / "out")
        print(*other[:20], sep="\n")
        return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
