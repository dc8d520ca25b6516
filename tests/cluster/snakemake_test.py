#!/usr/bin/env python3
"""CTest `snakemake`: the example's graph makes the block that one run makes, byte for byte.

    snakemake_test.py ORIENT SNAKEFILE

Skipped (77) without Debian's snakemake.
"""

import pathlib
import shutil
import sys
import tempfile

from slurm_test import contents, make_block, run

SKIPPED = 77


def main(orient, snakefile):
    if not shutil.which("snakemake"):
        print("snakemake is not installed")
        return SKIPPED
    orient = pathlib.Path(orient).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        one, many = pathlib.Path(temporary) / "one", pathlib.Path(temporary) / "many"
        make_block(orient, one, 4)
        shutil.copytree(one, many)
        run(orient, "block", one / "block.toml", codes=(0, 3))
        run("snakemake", "--snakefile", snakefile, "--cores", 2, "--directory", many, "--config",
            f"block={many}/block.toml", "parts=3", f"orient={orient}")
        expected, made = contents(one / "out"), contents(many / "out")
        other = sorted(name for name in expected.keys() | made.keys()
                       if expected.get(name) != made.get(name))
        print(f"{len(other)} of {len(expected)} files are other than those of one run", *other[:20])
        return 1 if other or not expected else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
