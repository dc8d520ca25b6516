#!/usr/bin/env python3
"""How much faster are two workers than one, and how long does a part take to start?

    workers.py ORIENT [PHOTOS]

A block of small digital photos is oriented (exterior orientation) by one process and by two in
parallel, each with one thread; then a part with nothing left to do is timed in blocks of 2,000 and
20,000 photos. Prints the figures for docs/evidence/many_machines.md and
tools/bench/cluster_model.py.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/cluster"))
from simulated_block import SMALL_DIGITAL, make_block, run  # noqa: E402


def seconds_of(orient, block, parts):
    start = time.monotonic()
    runs = [subprocess.Popen([orient, "block", block, "--stage", "exterior", "--part",
                              f"{part}/{parts}", "--jobs", "1"], stdout=subprocess.DEVNULL)
            for part in range(1, parts + 1)]
    if any(one.wait() != 0 for one in runs):
        sys.exit("a part has failed")
    return time.monotonic() - start


def efficiency(orient, folder, photos):
    seconds = {}
    for workers in (1, 2):
        shutil.rmtree(folder / "out", ignore_errors=True)
        seconds[workers] = seconds_of(orient, folder / "block.toml", workers)
        print(f"{workers} workers: {seconds[workers]:.1f} s, "
              f"{3600 * photos / seconds[workers]:.0f} photos an hour")
    print(f"two are {seconds[1] / seconds[2]:.2f} times one: "
          f"{50 * seconds[1] / seconds[2]:.0f} % of twice")


def start_of_part(orient, folder, photos):
    """Seconds for a part that has nothing to do, in a block of this many photos."""
    many = folder / f"many_{photos}"
    (many / "scans").mkdir(parents=True)
    scan = next((folder / "scans").glob("*.tif"))
    rows = (folder / "approx.csv").read_text().splitlines()
    lines = [rows[0]]
    for i in range(photos):
        os.link(scan, many / f"scans/p{i:06}.tif")
        lines.append(re.sub(r"^[^,]+", f"p{i:06}", rows[1]))
    (many / "approx.csv").write_text("\n".join(lines) + "\n")
    for file in ("approx.prj", "camera.toml", "dem.tif", "patches.gpkg", "block.toml"):
        shutil.copy(folder / file, many / file)
    # The part is the block's last photo alone; its result is there after the first run.
    words = [orient, "block", many / "block.toml", "--stage", "exterior", "--part",
             f"{photos}/{photos}", "--jobs", "1"]
    run(*words)
    start = time.monotonic()
    run(*words)
    return time.monotonic() - start


def main(orient, photos="24"):
    orient = pathlib.Path(orient).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "block"
        make_block(orient, folder, photos, *SMALL_DIGITAL)
        efficiency(orient, folder, int(photos))
        for many in (2000, 20000):
            print(f"a part with nothing to do, block of {many} photos: "
                  f"{start_of_part(orient, folder, many):.2f} s")


if __name__ == "__main__":
    main(*sys.argv[1:]) if len(sys.argv) > 1 else sys.exit(__doc__)
