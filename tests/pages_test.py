#!/usr/bin/env python3
"""CTests `quick_start_...` and `next_...`: the commands of a page do what the page says.

    pages_test.py ORIENT PAGE...          runs the pages' `sh` code blocks one after another in an
                                          empty folder, with ORIENT's folder on the path. Each must
                                          exit with 0, and every file in the tables of results must
                                          exist. `next` is removed before each page.
    pages_test.py --needs PROGRAM ORIENT PAGE...    skipped (77) if PROGRAM is not installed
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
BLOCK = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
RESULT = re.compile(r"^\| `([^`]+)` \|", re.MULTILINE)


def run_page(page, path, folder):
    text = pathlib.Path(page).read_text(encoding="utf-8")
    commands, results = BLOCK.findall(text), RESULT.findall(text)
    if not commands:
        sys.exit(f"{page} has no commands")
    shutil.rmtree(folder / "next", ignore_errors=True)
    for command in commands:
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=folder, text=True,
                              env={**os.environ, "PATH": path}, capture_output=True, check=False)
        print(done.stdout, flush=True)
        if done.returncode != 0:
            sys.exit(f"{page}: exit code {done.returncode} of\n{command}\n{done.stdout[-3000:]}\n"
                     f"{done.stderr[-3000:]}")
    missing = [name for name in results if not (folder / name).exists()]
    if missing:
        sys.exit(f"{page} promises {', '.join(missing)}")
    return len(results)


def main(program, *pages):
    path = f"{pathlib.Path(program).resolve().parent}:{os.environ['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        results = sum(run_page(page, path, pathlib.Path(folder)) for page in pages)
    if results == 0:
        sys.exit(f"{', '.join(pages)}: there is no table of results")


if __name__ == "__main__":
    words = sys.argv[1:]
    if words[:1] == ["--needs"]:
        if not shutil.which(words[1]):
            print(f"{words[1]} is not installed")
            sys.exit(SKIPPED)
        words = words[2:]
    main(*words)
