#!/usr/bin/env python3
"""CTest `snakemake`: the example workflow gives the same block as a single run, byte for byte.

    snakemake_test.py ORIENT SNAKEFILE

Skipped (77) without Debian's snakemake.
"""

import pathlib
import shutil
import sys
import tempfile

from simulated_block import SMALL_DIGITAL, complaints_about_difference, make_block, run

SKIPPED = 77


def main(orient, snakefile):
    if not shutil.which("snakemake"):
        print("snakemake is not installed")
        return SKIPPED
    orient = pathlib.Path(orient).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        one, many = pathlib.Path(temporary) / "one", pathlib.Path(temporary) / "many"
        make_block(orient, one, 4, *SMALL_DIGITAL)
        shutil.copytree(one, many)
        run(orient, "block", one / "block.toml", codes=(0, 3))
        run("snakemake", "--snakefile", snakefile, "--cores", 2, "--directory", many, "--config",
            f"block={many}/block.toml", "parts=3", f"orient={orient}")
        other = complaints_about_difference(one / "out", many / "out")
        print(*other[:20], sep="\n")
        return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
