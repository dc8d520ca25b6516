#!/usr/bin/env python3
"""CTest `quick_start_...`: the commands of a page of docs/quick do what the page says.

    quick_start_test.py ORIENT PAGE   runs the page's blocks of `sh`, one after another, in an empty
                                      folder with ORIENT's folder on the path; each must end with 0,
                                      and every file of the table of results must be there
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
RESULT = re.compile(r"^\| `([^`]+)` \|", re.MULTILINE)


def main(program, page):
    text = pathlib.Path(page).read_text(encoding="utf-8")
    commands, results = BLOCK.findall(text), RESULT.findall(text)
    if not commands or not results:
        sys.exit(f"{page} has no commands or no table of results")
    path = f"{pathlib.Path(program).resolve().parent}:{os.environ['PATH']}"
    with tempfile.TemporaryDirectory() as folder:
        for command in commands:
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=folder, text=True,
                                  env={**os.environ, "PATH": path}, capture_output=True, check=False)
            print(done.stdout)
            if done.returncode != 0:
                sys.exit(f"exit code {done.returncode} of\n{command}\n{done.stderr}")
        missing = [name for name in results if not (pathlib.Path(folder) / name).exists()]
        if missing:
            sys.exit(f"{page} promises {', '.join(missing)}")


if __name__ == "__main__":
    main(*sys.argv[1:])
