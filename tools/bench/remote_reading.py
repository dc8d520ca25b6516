#!/usr/bin/env python3
"""How much of a scan is read over the network for interior and for exterior orientation?

    remote_reading.py ORIENT [FOLDER [POSITION_M ATTITUDE_DEG]]

Simulates a 9,244 px scan of 23 cm film (takes minutes; kept in FOLDER), harvests 800, 150 and 60
patches per photo, writes the scan in four layouts, serves it, and counts the bytes sent by the
server. Prints a table for docs/evidence/many_machines.md. Approximations are accurate to 10 m and 3
degrees, or to POSITION_M and ATTITUDE_DEG.
"""

import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/cluster"))
from object_store import ObjectStore  # noqa: E402
from object_store_test import with_scans  # noqa: E402
from simulated_block import harvest, run  # noqa: E402

LAYOUTS = {"tiles of 256, no overviews": None, "COG, tiles of 512": "512", "COG, tiles of 256": "256",
           "COG, tiles of 128": "128"}
SCAN = "scans/new_1_1.tif"


def simulate(orient, folder, position_m, attitude_deg):
    if not (folder / SCAN).exists():
        run(orient, "simulate", "--out", folder, "--photos", 1, "--camera-preset", "rc30",
            "--pixel-size-um", 25, "--position-error-m", position_m, "--attitude-error-deg",
            attitude_deg)


def write_layout(folder, block_size):
    target = folder / "served/new_1_1.tif"
    target.parent.mkdir(exist_ok=True)
    if block_size is None:
        shutil.copy(folder / SCAN, target)
    else:
        subprocess.run(["gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=LZW", "-co",
                        f"BLOCKSIZE={block_size}", "-co", "OVERVIEWS=IGNORE_EXISTING", "-co",
                        "RESAMPLING=AVERAGE", folder / SCAN, target], check=True)
    return target.stat().st_size


def shares(orient, folder, size):
    """(requests, share of the scan) of both stages."""
    shutil.rmtree(folder / "remote", ignore_errors=True)
    found = []
    with ObjectStore(folder / "served") as store:
        block = with_scans(folder, "remote.toml", [store.url + "/new_1_1.tif"], "remote")
        for stage in ("interior", "exterior"):
            sent, requests = store.bytes_sent, store.requests
            run(orient, "block", block, "--stage", stage)
            found.append((store.requests - requests, (store.bytes_sent - sent) / size))
    return found


def measure(orient, folder, position_m=10, attitude_deg=3):
    simulate(orient, folder, position_m, attitude_deg)
    print("| layout | patches per photo | interior: requests, share | exterior: requests, share |")
    print("|---|---|---|---|")
    for patches in (800, 150, 60):
        harvest(orient, folder, "--max-per-photo", patches)
        for name, block_size in LAYOUTS.items():
            (a, interior), (b, exterior) = shares(orient, folder, write_layout(folder, block_size))
            print(f"| {name} | {patches} | {a}, {100 * interior:.0f} % | {b}, "
                  f"{100 * exterior:.0f} % |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) in (3, 5):
        measure(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]), *sys.argv[3:])
    elif len(sys.argv) == 2:
        with tempfile.TemporaryDirectory() as temporary:
            measure(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(temporary) / "block")
    else:
        sys.exit(__doc__)
