#!/usr/bin/env python3
"""Prints how many tests ran and how many were skipped, which is lost in hundreds of lines.

    count_skipped.py TESTS.xml    TESTS.xml: written by `ctest --output-junit`
"""

import re
import sys
import xml.etree.ElementTree

NO_DATA = "real data absent (ORIENT_SHARED_DATA)"  # as the tests print it
# A GoogleTest suite is one test for CTest; with --gtest_brief it ends with this summary.
PASSED = re.compile(r"^\[  PASSED  \] (\d+) tests?\.$", re.MULTILINE)
SKIPPED = re.compile(r"^(\S+:\d+): Skipped\n(.*)$", re.MULTILINE)


def main(path):
    passed, skipped = 0, []
    for case in xml.etree.ElementTree.parse(path).iter("testcase"):
        output = case.findtext("system-out") or ""
        if case.find("skipped") is not None:
            skipped.append((case.get("name"), output))
        elif PASSED.search(output):
            passed += int(PASSED.search(output)[1])
            skipped += SKIPPED.findall(output)
        elif case.find("failure") is None:
            passed += 1
    without_data = [test for test in skipped if NO_DATA in test[1]]
    print(f"{passed} tests passed, {len(skipped)} skipped, {len(without_data)} of them for lack of "
          "ORIENT_SHARED_DATA")
    for test in skipped:
        if test not in without_data:
            print(f"  skipped for another reason: {test[0]}")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]) if len(sys.argv) == 2 else __doc__)
