#!/usr/bin/env python3
"""CTest `layers`: no folder includes what the design forbids, without an exception list.

    layers_test.py ROOT          checks the sources below ROOT
    layers_test.py --self-test   proves that a forbidden include is found

The table below is the one of docs/design.md: who may use whom, and which library from outside
lives in which room. A folder or library that the table does not know is an error too. And no two
headers define a type of one name: everything lives in one namespace, so the linker would take one
for the other without a word.
"""

import pathlib
import re
import sys
import tempfile

CORE = {"core/geometry", "core/imaging", "core/files"}
EVERYTHING = CORE | {"interior", "patchdb", "exterior", "tools", "tests"}

# folder: (folders it may include besides its own, libraries from outside)
TABLE = {
    "core": (set(), set()),  # core/error.h alone
    "core/geometry": (set(), {"Eigen", "Ceres", "GDAL"}),
    "core/imaging": ({"core/geometry"}, {"Eigen", "OpenCV", "GDAL", "TBB", "libdeflate"}),
    "core/files": ({"core/geometry"}, {"Eigen", "toml++", "nlohmann-json"}),
    "interior": (CORE, {"Eigen", "TBB"}),
    "patchdb": (CORE, {"Eigen", "SQLite", "TBB"}),
    "exterior": (CORE | {"patchdb"}, {"Eigen", "Ceres", "TBB"}),
    "tools": (EVERYTHING - {"tests"}, {"Eigen", "GDAL", "CLI11", "nlohmann-json", "TBB"}),
    # What a benchmark compares with may be another library's.
    "tools/bench": (EVERYTHING - {"tests"}, {"Eigen", "GDAL", "CLI11", "nlohmann-json", "OpenCV", "TBB"}),
    "tests": (EVERYTHING | {"tools/bench"},
              {"Eigen", "Ceres", "GDAL", "SQLite", "CLI11", "nlohmann-json", "TBB", "libdeflate",
               "GoogleTest", "RapidCheck"}),
}

# How the headers of a library from outside begin.
LIBRARIES = {
    "Eigen": r"(unsupported/)?Eigen/",
    "Ceres": r"ceres/",
    "GDAL": r"(gdal|ogr|cpl_|vrt|proj)[a-z0-9_]*\.h$",
    "OpenCV": r"opencv2/",
    "TBB": r"(oneapi/)?tbb/",
    "toml++": r"toml\+\+/",
    "nlohmann-json": r"nlohmann/",
    "libdeflate": r"libdeflate\.h$",
    "SQLite": r"(SQLiteCpp/|sqlite3\.h$)",
    "CLI11": r"CLI/",
    "GoogleTest": r"(gtest|gmock)/",
    "RapidCheck": r"rapidcheck(\.h$|/)",
}
# The C++ standard library has neither a folder nor an extension; of POSIX we use these.
STANDARD = re.compile(r"^([a-z_0-9]+|(unistd|fcntl|fnmatch|glob|malloc|signal)\.h|sys/[a-z]+\.h)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
DEFINED_TYPE = re.compile(r"^(?:struct|class|enum class) (\w+)\s*(?:final\s*)?(?:[:{]|$)")
VAGUE_NAME = re.compile(r"(^|_)(utils?|common|misc)(_|$)")


def folder_of(path):
    """The room a file path belongs to: its longest prefix in the table."""
    parts = path.split("/")[:-1]
    for length in (2, 1):
        room = "/".join(parts[:length])
        if len(parts) >= length and room in TABLE:
            return room
    return None


def own_folder(path):
    return path.rsplit("/", 1)[0] + "/"


def library_of(header):
    for name, pattern in LIBRARIES.items():
        if re.match(pattern, header):
            return name
    return None


def complaint_about(path, kind, header):
    """Why `path` may not include `header`; None where it may."""
    room = folder_of(path)
    folders, libraries = TABLE[room]
    if kind == '"':
        target = folder_of(header)
        if target is None:
            return "is not a path from the project's root into a folder of the design"
        if target not in folders | {room, "core"}:
            return f"{room} may not use {target}"
        if target == "tests" and not header.startswith(("tests/support/", own_folder(path))):
            return "tests of different folders share helpers through tests/support only"
        return None
    library = library_of(header)
    if library is None:
        return None if STANDARD.match(header) else "belongs to no library of the table"
    if library not in libraries:
        return f"{room} may not use {library}"
    if library == "OpenCV" and path.endswith(".h"):
        return "OpenCV's types never appear in a header"
    return None


def is_product_header(path):
    return path.endswith(".h") and not path.startswith("tests/")


def complaints(root):
    root = pathlib.Path(root)
    found, files, home = [], 0, {}
    rooms = sorted({room.split("/")[0] for room in TABLE})
    sources = [p for room in rooms for p in sorted((root / room).rglob("*.*"))
               if p.suffix in (".h", ".cpp")]
    for source in sources:
        files += 1
        path = source.relative_to(root).as_posix()
        if folder_of(path) is None:
            found.append(f"{path}: lies in no folder of the design")
            continue
        if any(VAGUE_NAME.search(part) for part in path.rsplit(".", 1)[0].split("/")):
            found.append(f"{path}: util, common and misc say nothing; name it after what it does")
        for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            reason = match and complaint_about(path, match[1], match[2])
            if reason:
                found.append(f"{path}:{number}: {match[2]}: {reason}")
            defined = DEFINED_TYPE.match(line) if is_product_header(path) else None
            if defined and home.setdefault(defined[1], path) != path:
                found.append(f"{path}:{number}: {defined[1]} is a type of {home[defined[1]]} too")
    return found, files


FORBIDDEN = [
    ("core/geometry/a.h", '#include "core/imaging/image.h"'),
    ("core/imaging/a.cpp", '#include "core/files/results.h"'),
    ("core/files/a.cpp", '#include "core/imaging/image.h"'),
    ("core/files/a.cpp", '#include "interior/orient.h"'),
    ("interior/a.cpp", '#include "exterior/align.h"'),
    ("interior/a.cpp", '#include "patchdb/patch.h"'),
    ("exterior/a.cpp", '#include "interior/orient.h"'),
    ("patchdb/a.h", '#include "exterior/align.h"'),
    ("exterior/a.cpp", '#  include "tools/command.h"'),
    ("interior/a.h", '#include "tests/support/shared_data.h"'),
    ("interior/a.h", '#include "neighbour.h"'),
    ("core/error.h", '#include "core/geometry/pose.h"'),
    ("exterior/a.cpp", "#include <SQLiteCpp/Database.h>"),
    ("tools/a.cpp", "#include <sqlite3.h>"),
    ("interior/a.cpp", "#include <opencv2/core.hpp>"),
    ("core/imaging/a.h", "#include <opencv2/core.hpp>"),
    ("tools/a.cpp", "#include <opencv2/core.hpp>"),
    ("interior/a.cpp", "#include <gdal_priv.h>"),
    ("exterior/a.cpp", "#include <ogr_spatialref.h>"),
    ("interior/a.cpp", "#include <ceres/ceres.h>"),
    ("core/geometry/a.cpp", "#include <toml++/toml.h>"),
    ("exterior/a.cpp", "#include <boost/optional.hpp>"),
    ("tests/interior/a_test.cpp", '#include "tests/exterior/scene.h"'),
    ("interior/utils.h", ""),
    ("interior/image_util.cpp", ""),
]
ALLOWED = [
    ("core/geometry/a.cpp", "#include <ceres/ceres.h>"),
    ("core/geometry/a.cpp", "#include <ogr_spatialref.h>"),
    ("core/imaging/a.cpp", "#include <opencv2/core.hpp>"),
    ("tools/bench/a.cpp", "#include <opencv2/features2d.hpp>"),
    ("core/files/a.cpp", '#include "core/geometry/pose.h"'),
    ("core/files/a.cpp", "#include <sys/stat.h>"),
    ("interior/a.cpp", '#include "core/imaging/image.h"'),
    ("interior/a.cpp", '#include "core/error.h"'),
    ("exterior/a.cpp", '#include "patchdb/patch.h"'),
    ("exterior/steps/a.cpp", '#include "exterior/predict.h"'),
    ("patchdb/a.cpp", "#include <SQLiteCpp/Database.h>"),
    ("tools/a.cpp", '#include "exterior/align.h"'),
    ("tests/tools/a_test.cpp", '#include "tests/support/shared_data.h"'),
    ("tests/tools/a_test.cpp", '#include "tests/tools/scene.h"'),
    ("core/files/a.cpp", "// #include <opencv2/core.hpp> would be wrong here"),
    ("core/files/a.cpp", "#include <vector>"),
]


def check_one(path, line):
    with tempfile.TemporaryDirectory() as root:
        file = pathlib.Path(root) / path
        file.parent.mkdir(parents=True)
        file.write_text(f"#pragma once\n{line}\n", encoding="utf-8")
        return complaints(root)[0]


def same_name_is_found():
    with tempfile.TemporaryDirectory() as root:
        for folder in ("interior", "exterior"):
            (pathlib.Path(root) / folder).mkdir()
            (pathlib.Path(root) / folder / "a.h").write_text("struct Peak {\n};\n", encoding="utf-8")
        return len(complaints(root)[0]) == 1


def self_test():
    wrong = [] if same_name_is_found() else ["missed: two headers that define one type"]
    wrong += [f"missed: {path} {line}" for path, line in FORBIDDEN if not check_one(path, line)]
    wrong += [f"refused: {path} {line}" for path, line in ALLOWED if check_one(path, line)]
    print("\n".join(wrong) or f"{len(FORBIDDEN)} forbidden includes found, {len(ALLOWED)} allowed")
    return 1 if wrong else 0


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) != 1:
        print(__doc__)
        return 2
    found, files = complaints(arguments[0])
    if files == 0:
        found.append(f"{arguments[0]}: no sources found; is this the project's root?")
    print("\n".join(found) or f"{files} files keep to the layers")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
