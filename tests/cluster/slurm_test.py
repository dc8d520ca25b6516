#!/usr/bin/env python3
"""CTest `slurm`: a block run by `orient slurm --submit`, whose nodes and jobs are killed, is byte
for byte the block of a single machine, and arrives as such in object storage.

    slurm_test.py ORIENT [PHOTOS [SEED]]

Skipped (77) without Debian's slurm-wlm and munge, or without root.
"""

import json
import os
import pathlib
import random
import shutil
import signal
import sys
import tempfile
import time

from bucket_store import BucketStore
from simulated_block import SMALL_DIGITAL, complaints_about_difference, make_block, run
from slurm_on_one_machine import SlurmOnOneMachine, why_not_here

SKIPPED = 77
KILLED_JOBS = 4
KILLED_NODES = 2
MOST_SECONDS = 3000

def orient_processes(orient, block):
    """Ids of running processes that orient parts of this block as jobs."""
    found = []
    for process in pathlib.Path("/proc").iterdir():
        try:
            words = (process / "cmdline").read_bytes().split(b"\0") if process.name.isdigit() else []
        except OSError:
            continue
        if len(words) > 2 and words[0].decode() == str(orient) and words[2].decode() == str(block):
            found.append(int(process.name))
    return found


def disturb(slurm, orient, block, draw):
    """Kills jobs and nodes until the intended numbers are reached or all jobs have ended."""
    jobs, nodes = KILLED_JOBS, KILLED_NODES
    until = time.monotonic() + MOST_SECONDS
    down = None
    while slurm.waiting_or_running():
        if time.monotonic() > until:
            sys.exit(f"the jobs have not ended after {MOST_SECONDS} s:\n{slurm.run('squeue')}")
        time.sleep(draw.uniform(0.2, 1.5))
        running = orient_processes(orient, block)
        if jobs > 0 and running and draw.random() < 0.5:
            os.kill(draw.choice(running), signal.SIGKILL)
            jobs -= 1
        elif nodes > 0 and down is None and running and draw.random() < 0.3:
            down = (draw.choice(["n1", "n2"]), time.monotonic() + 15)
            slurm.kill_node(down[0])
            nodes -= 1
        if down is not None and time.monotonic() > down[1]:
            slurm.start_node(down[0])
            down = None
    print(f"killed: {KILLED_JOBS - jobs} jobs, {KILLED_NODES - nodes} nodes")
    if jobs == KILLED_JOBS or nodes == KILLED_NODES:
        sys.exit("the jobs ended before one of them and a node were killed: give more photos")


def complaints_about_upload(out, place):
    listed = json.loads((place / "orient-upload.json").read_text())["files"]
    other = [name for name in listed if (place / name).read_bytes() != (out / name).read_bytes()]
    missing = [name for name in ("block.json", "report.html") if name not in listed]
    return [f"uploaded otherwise: {name}" for name in other + missing]


def main(orient, photos="60", seed="1"):
    reason = why_not_here()
    if reason:
        print(reason)
        return SKIPPED
    orient = pathlib.Path(orient).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        one, many = pathlib.Path(temporary) / "one", pathlib.Path(temporary) / "many"
        make_block(orient, one, photos, *SMALL_DIGITAL)
        shutil.copytree(one, many)
        run(orient, "block", one / "block.toml", codes=(0, 3))
        block = many / "block.toml"
        stored = pathlib.Path(temporary) / "store"
        (stored / "archive").mkdir(parents=True)
        with SlurmOnOneMachine(pathlib.Path(temporary) / "slurm") as slurm, \
                BucketStore(stored, busy=0.05) as store:
            os.environ |= store.environment() | {"SLURM_CONF": slurm.environment["SLURM_CONF"]}
            print(run(orient, "slurm", block, "--parts", 12, "--submit", "--upload",
                      "s3://archive/block").stdout)
            disturb(slurm, orient, block, random.Random(int(seed)))
        print(run(orient, "block", block, "--status").stdout)
        other = complaints_about_difference(one / "out", many / "out")
        other += complaints_about_upload(many / "out", stored / "archive/block")
        for log in sorted((many / "out/slurm/logs").glob("*.log")) if other else []:
            print(f"== {log.name}\n{log.read_text()}")
        print(*other[:20], sep="\n")
        return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
