#!/usr/bin/env python3
"""CTest `object_store`: scans on an unreliable web server give the same results as local ones.

    object_store_test.py ORIENT [DELAY_S [PHOTOS [PIXEL_UM]]]

5 % of the requests are answered with 503, 1 % of the answers break off. Then the server refuses all
requests: the run exits with 4, no photo has failed, and the same command succeeds when the server
is back. Prints how many bytes were read.
"""

import json
import pathlib
import re
import sys
import tempfile

from object_store import ObjectStore
from simulated_block import complaints_about_difference, make_block, run

BUSY, CUT = 0.05, 0.01

def with_scans(folder, name, photos, out):
    text = (folder / "block.toml").read_text()
    text = re.sub(r"photos = .*", f"photos = {json.dumps(photos)}", text)
    text = text.replace('directory = "out"', f'directory = "{out}"')
    (folder / name).write_text(text)
    return folder / name


def statuses(out):
    return sorted(json.loads(path.read_text())["status"] for path in out.glob("*.interior.json"))


def complaints_about_refusals(orient, folder):
    """Busy and slow servers (503, 429, 408), one that hardly ever answers, and refused files."""
    found = []
    once = ("env", "GDAL_HTTP_MAX_RETRY=0", orient, "block")
    with ObjectStore(folder, busy=1) as store:
        names = sorted(f"{store.url}/scans/{scan.name}" for scan in (folder / "scans").glob("*.tif"))
        for code, exit_code in ((503, 4), (429, 4), (408, 4), (404, 3), (403, 3)):
            store.code = code
            block = with_scans(folder, f"{code}.toml", names, f"{code}")
            run_ended = run(*once, block, codes=range(256))
            failed = [status for status in statuses(folder / f"{code}") if status == "failed"]
            if run_ended.returncode != exit_code or bool(failed) != (exit_code == 3):
                found.append(f"a server that says {code}: exit code {run_ended.returncode}, "
                             f"{failed}: {run_ended.stderr}")
        store.busy, store.code = 0.7, 503
        hardly = run(*once, with_scans(folder, "hardly.toml", names, "hardly"), codes=range(256))
        if hardly.returncode not in (0, 4) or "failed" in statuses(folder / "hardly"):
            found.append(f"a server that hardly ever answers: {hardly.returncode} {hardly.stdout}")
        store.busy = 0
        back = run(orient, "block", folder / "503.toml", codes=range(256))
        if back.returncode != 0 or set(statuses(folder / "503")) != {"ok"}:
            found.append(f"when it is back: {back.returncode} {back.stdout}{back.stderr}")
    return found


def main(orient, delay_s="0.02", photos="3", pixel_um="25"):
    orient = pathlib.Path(orient).resolve()
    found = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / "block"
        make_block(orient, folder, photos, "--pixel-size-um", pixel_um)
        run(orient, "block", folder / "block.toml")
        scans = sum(scan.stat().st_size for scan in (folder / "scans").glob("*.tif"))
        with ObjectStore(folder, BUSY, CUT, float(delay_s)) as store:
            # A wildcard in the URL: the server lists its folder.
            block = with_scans(folder, "remote.toml", [store.url + "/scans/*.tif"], "remote")
            for stage in ("interior", "exterior"):
                run(orient, "block", block, "--stage", stage)
            share = store.bytes_sent / scans
            print(f"interior and exterior: {store.requests} requests, {store.faults} faults, "
                  f"{store.bytes_sent / 1e6:.1f} MB, {100 * share:.0f} % of the scans")
            run(orient, "block", block)
            print(f"block: {store.requests} requests, {store.faults} faults, "
                  f"{store.bytes_sent / 1e6:.1f} MB")
            if store.cuts == 0 or store.faults <= store.cuts:
                found.append("not both kinds of faults have occurred: nothing was tried")
        found += complaints_about_difference(folder / "out", folder / "remote")
        found += complaints_about_refusals(orient, folder)
    print("\n".join(found) or "scans on a web server give what local ones give")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
