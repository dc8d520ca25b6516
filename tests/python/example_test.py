#!/usr/bin/env python3
"""CTest `python_example`: the notebook-like example runs, and its results are close to the truth.

    example_test.py PACKAGES EXAMPLE   folder with the package `orient`, and the example's file
"""

import contextlib
import io
import os
import runpy
import sys
import tempfile

MOST_SIGMAS = 4.5  # largest normalised error of a pose element


def main(packages, example):
    sys.path.insert(0, packages)
    import numpy as np
    example, said = os.path.abspath(example), io.StringIO()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        with contextlib.redirect_stdout(said):
            names = runpy.run_path(example)
        os.chdir("/")
    found = []
    if names["block"].statuses != ["ok"] * 3:
        found.append(f"the photos are {names['block'].statuses}")
    worst = np.abs(names["errors"] / names["sigmas"]).max()
    if not worst < MOST_SIGMAS:
        found.append(f"a pose is off by {worst} sigmas")
    off = np.abs(names["patches"]["pixel"][names["matched"]] - names["pixels"])
    if not np.median(off) < 0.5:
        found.append(f"patches lie {np.median(off)} px off where the photo's geometry puts them")
    if "exterior orientation: 3 of 3" not in said.getvalue():
        found.append("the progress did not come to its end")
    print("\n".join(found) or said.getvalue())
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 3 else __doc__)
