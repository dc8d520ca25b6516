#!/usr/bin/env python3
"""Says how many tests were skipped, which nobody sees in hundreds of lines.

    count_skipped.py TESTS.xml    what `ctest --output-junit` wrote
"""

import sys
import xml.etree.ElementTree

NO_DATA = "real data absent (ORIENT_SHARED_DATA)"  # the tests' own words


def main(path):
    skipped = [case for case in xml.etree.ElementTree.parse(path).iter("testcase")
               if case.find("skipped") is not None]
    without_data = [case for case in skipped if NO_DATA in (case.findtext("system-out") or "")]
    print(f"{len(skipped)} tests skipped, {len(without_data)} of them for lack of "
          "ORIENT_SHARED_DATA")
    for case in skipped:
        if case not in without_data:
            print(f"  skipped for another reason: {case.get('name')}")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]) if len(sys.argv) == 2 else __doc__)
