#!/usr/bin/env python3
"""Says how many tests ran and how many were skipped, which nobody sees in hundreds of lines.

    count_skipped.py TESTS.xml    what `ctest --output-junit` wrote
"""

import re
import sys
import xml.etree.ElementTree

NO_DATA = "real data absent (ORIENT_SHARED_DATA)"  # the tests' own words
# A suite of GoogleTest is one test of CTest; with --gtest_brief it says so at its end.
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
