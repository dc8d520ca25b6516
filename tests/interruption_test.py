#!/usr/bin/env python3
"""CTest `interruption`: after Ctrl-C, a run dies of the signal and says how to continue.

    interruption_test.py ORIENT
"""

import pathlib
import signal
import subprocess
import sys
import tempfile
import time

MOST_S = 60


def interrupted(orient, folder, number, *options):
    """(standard error, exit code, log) of a simulation interrupted once it had begun."""
    log = folder / f"{number}.log"
    run = subprocess.Popen([orient, "simulate", "--out", folder / "block", "--photos", "20",
                            "--log", log, *options], stdout=subprocess.DEVNULL,
                           stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + MOST_S
    while not (log.exists() and log.read_text(encoding="utf-8")) and time.monotonic() < end:
        time.sleep(0.01)
    time.sleep(0.2)  # the advice follows the log's first line
    run.send_signal(number)
    return run.communicate(timeout=MOST_S)[1], run.returncode, log.read_text(encoding="utf-8")


def main(orient):
    found = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for number, options in ((signal.SIGINT, ()), (signal.SIGTERM, ("--quiet", "--overwrite"))):
            said, code, log = interrupted(orient, folder, number, *options)
            words = "interrupted; repeat the command with --overwrite\n"
            if said != "orient: " + words:
                found.append(f"{number.name}: said {said!r}")
            if code != -number:
                found.append(f"{number.name}: ended with {code}")
            if not log.endswith("Z " + words):
                found.append(f"{number.name}: logged {log!r}")
        # Started with the signal ignored, as by nohup: it continues.
        ignoring = subprocess.run(["bash", "-c", f"trap '' INT; '{orient}' cameras & "
                                   "sleep 0.02; kill -INT $!; wait $!"], capture_output=True,
                                  text=True, check=False)
        if ignoring.returncode != 0 or "interrupted" in ignoring.stderr:
            found.append(f"ignored: {ignoring}")
    print("\n".join(found) or "interrupted runs say how to go on")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]) if len(sys.argv) == 2 else __doc__)
