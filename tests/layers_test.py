#!/usr/bin/env python3
"""CTest `layers`: every include follows the table of modules, without exceptions.

    layers_test.py ROOT          checks the sources below ROOT
    layers_test.py --self-test   checks that forbidden includes are found

The table below is that of docs/design.md: which folders a folder may use, including subfolders, and
which external libraries. A folder or library that is not in the table is an error, too. In
addition: no circular includes between units (a header with its source); no two headers of a module
define types of the same name, which the linker would silently confuse; no folder has more than 40
files, and no file of the product more than 400 lines.
"""

import pathlib
import re
import sys
import tempfile

CORE = ["core/base", "core/base/geopackage", "core/geometry", "core/terrain", "core/raster",
        "core/matching", "core/files", "core/measurements", "core/exchange"]
INTERIOR = ["interior/marks", "interior/locators", "interior/constellation", "interior/orientation",
            "interior"]
EXTERIOR = ["exterior/steps", "exterior/search", "exterior"]
BLOCK = ["block/roll", "block/bundle", "block/ties", "block/inputs", "block/pictures",
         "block/stages", "block/verdict", "block"]

# folder: (folders it may include besides its own, external libraries). Within a module, folders are
# listed in the order in which they build on one another.
TABLE = {
    "core/base/geopackage": ([], {"SQLite"}),
    "core/base": (["core/base/geopackage"], {"Boost.Math", "fmt", "GDAL", "TBB"}),
    "core/geometry": (["core/base"], {"Eigen", "Ceres"}),
    "core/terrain": (["core/base", "core/geometry"], {"Eigen", "GDAL"}),
    "core/raster": (["core/base"], {"Eigen", "OpenCV", "GDAL", "libdeflate", "libspng"}),
    "core/matching": (["core/base", "core/geometry", "core/raster"],
                      {"Eigen", "OpenCV", "intrinsics"}),
    "core/files": (["core/base", "core/geometry", "core/terrain"],
                   {"Eigen", "toml++", "nlohmann-json"}),
    "core/measurements": (["core/base", "core/geometry", "core/files"], {"Eigen"}),
    "core/exchange": (["core/base", "core/geometry", "core/terrain", "core/files",
                       "core/measurements"],
                      {"Eigen", "nlohmann-json", "pugixml"}),
    "patchdb/store": (["core/base", "core/base/geopackage", "core/geometry", "core/terrain",
                       "core/raster"],
                      {"Eigen", "SQLite"}),
    "patchdb/store/schema": (["core/base", "core/base/geopackage", "patchdb/store"], set()),
    "patchdb/maintenance": (["core/base", "core/base/geopackage", "core/geometry", "core/terrain",
                             "core/raster", "patchdb/store"], {"Eigen", "SQLite"}),
    "patchdb/regions": (["core/base", "core/geometry", "core/terrain", "patchdb/store",
                         "patchdb/maintenance"], {"Eigen", "nlohmann-json"}),
    "patchdb/harvest": (["core/base", "core/geometry", "core/terrain", "core/raster",
                         "core/matching", "patchdb/store"], {"Eigen"}),
    "tools/simulate": (CORE[:-1], {"Eigen", "GDAL", "TBB", "nlohmann-json"}),
    "tools/report/figures": (CORE + INTERIOR + ["block/inputs"], {"Eigen"}),
    "tools/report": (CORE + INTERIOR + ["block/inputs", "tools/report/figures"],
                     {"Eigen", "GDAL", "nlohmann-json"}),
    "tools/convert": (CORE + INTERIOR + ["block/inputs"], {"Eigen", "GDAL", "TBB", "nlohmann-json"}),
    "tools/report/gis": (CORE + ["tools/report"], {"GDAL", "nlohmann-json"}),
    "tools/review": (CORE + ["block/inputs", "interior/marks", "tools/report"],
                     {"Eigen", "nlohmann-json", "cpp-httplib"}),
    "tools/console": (["core/base"], {"nlohmann-json"}),
    "tools/cluster": (CORE + ["block/inputs", "tools/report"], {"GDAL", "nlohmann-json"}),
    "tools/commands": (CORE + INTERIOR + EXTERIOR + BLOCK + ["ortho"]
                       + ["patchdb/store", "patchdb/harvest", "patchdb/maintenance", "patchdb/regions"]
                       + ["tools/simulate", "tools/report", "tools/report/figures",
                          "tools/report/gis", "tools/convert", "tools/review", "tools/console",
                          "tools/cluster"],
                       {"Eigen", "GDAL", "CLI11", "nlohmann-json"}),
}
TABLE["ortho"] = (CORE[:-1], {"Eigen", "GDAL", "OpenCV"})
for _order, _below, _libraries in (
        (INTERIOR, CORE[:-1], {"Eigen"}),
        (EXTERIOR, CORE[:-1] + ["patchdb/store"], {"Eigen"}),
        (BLOCK, CORE + INTERIOR + EXTERIOR + ["patchdb/store", "patchdb/maintenance",
                                               "patchdb/regions", "patchdb/harvest"],
         {"Eigen", "Ceres", "GDAL", "TBB", "nlohmann-json"})):
    for _place, _folder in enumerate(_order):
        TABLE[_folder] = (_below + _order[:_place], _libraries)
for _folder in ("tools/commands/block", "tools/commands/cameras", "tools/commands/patchdb",
                "tools/commands/review"):
    TABLE[_folder] = (TABLE["tools/commands"][0] + ["tools/commands"], TABLE["tools/commands"][1])
TABLE["tools/completion"] = (["tools/commands"], {"CLI11"})
PRODUCT = list(TABLE)
TABLE["python"] = (PRODUCT, {"Eigen", "pybind11"})
# A benchmark may compare with another library.
TABLE["tools/bench"] = (PRODUCT, TABLE["tools/commands"][1] | {"OpenCV", "TBB"})
TABLE["examples"] = (PRODUCT, {"Eigen"})
TABLE["tests"] = (PRODUCT + ["tools/bench"],
                  {"Eigen", "Ceres", "GDAL", "SQLite", "CLI11", "nlohmann-json", "TBB",
                   "libdeflate", "GoogleTest", "RapidCheck"})
MOST_FILES, MOST_LINES = 40, 400

# Patterns for the headers of external libraries.
LIBRARIES = {
    "Eigen": r"(unsupported/)?Eigen/",
    "intrinsics": r"immintrin\.h$",  # of the compiler
    "Boost.Math": r"boost/math/",
    "Ceres": r"ceres/",
    "fmt": r"fmt/",
    "GDAL": r"(gdal|ogr|cpl_|vrt|proj)[a-z0-9_]*\.h$",
    "OpenCV": r"opencv2/",
    "TBB": r"(oneapi/)?tbb/",
    "toml++": r"toml\+\+/",
    "nlohmann-json": r"nlohmann/",
    "libdeflate": r"libdeflate\.h$",
    "libspng": r"spng\.h$",
    "cpp-httplib": r"httplib\.h$",
    "pugixml": r"pugixml\.hpp$",
    "pybind11": r"pybind11/",
    "SQLite": r"(SQLiteCpp/|sqlite3\.h$)",
    "CLI11": r"CLI/",
    "GoogleTest": r"(gtest|gmock)/",
    "RapidCheck": r"rapidcheck(\.h$|/)",
}
# Headers of the C++ standard library have neither folder nor extension; of POSIX, we use these.
STANDARD = re.compile(r"^([a-z_0-9]+|(unistd|fcntl|fnmatch|glob|malloc|signal|dlfcn|execinfo|dirent|pwd)\.h|sys/[a-z]+\.h)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
DEFINED_TYPE = re.compile(r"^(?:struct|class|enum class) (\w+)\s*(?:final\s*)?(?:[:{]|$)")
VAGUE_NAME = re.compile(r"(^|_)(utils?|common|misc)(_|$)")


def folder_of(path):
    """The table's folder for a file: its own, or `tests` or `examples`; None if there is none."""
    folder = path.rpartition("/")[0]
    if folder.split("/")[0] in ("tests", "examples"):
        return folder.split("/")[0]
    return folder if folder in TABLE else None


def library_of(header):
    for name, pattern in LIBRARIES.items():
        if re.match(pattern, header):
            return name
    return None


def shared_by_tests(path, header):
    """Test helpers must be in tests/support or in a folder above the tests that use them."""
    return header.startswith("tests/support/") or path.startswith(header.rpartition("/")[0] + "/")


def complaint_about(path, kind, header):
    """Why `path` may not include `header`; None if it may."""
    folder = folder_of(path)
    folders, libraries = TABLE[folder]
    if kind == '"':
        target = folder_of(header)
        if target is None:
            return "is not a path from the project's root into a folder of the design"
        if target != folder and target not in folders:
            return f"{folder} may not use {target}"
        if target == "tests" and not shared_by_tests(path, header):
            return "tests of different folders share helpers through tests/support only"
        return None
    library = library_of(header)
    if library is None:
        return None if STANDARD.match(header) else "belongs to no library of the table"
    if library != "fmt" and library not in libraries:
        return f"{folder} may not use {library}"
    if library == "OpenCV" and path.endswith(".h"):
        return "OpenCV's types never appear in a header"
    return None


def unit_of(path):
    return path.rpartition(".")[0]


def circles(edges):
    """Sets of units with circular includes (Tarjan's strongly connected components)."""
    index, low, stack, found = {}, {}, [], []

    def visit(unit):
        index[unit] = low[unit] = len(index)
        stack.append(unit)
        for other in edges.get(unit, ()):
            if other not in index:
                visit(other)
                low[unit] = min(low[unit], low[other])
            elif other in stack:
                low[unit] = min(low[unit], index[other])
        if low[unit] == index[unit]:
            members = stack[stack.index(unit):]
            del stack[stack.index(unit):]
            if len(members) > 1:
                found.append(sorted(members))

    sys.setrecursionlimit(10000)
    for unit in sorted(edges):
        if unit not in index:
            visit(unit)
    return found


class SourceTree:
    """Checks the sources under a root; `found` lists what is wrong."""

    def __init__(self, root):
        self.root, self.files, self.found = pathlib.Path(root), 0, []
        self.home, self.edges, self.in_folder = {}, {}, {}
        for top in sorted({folder.split("/")[0] for folder in TABLE}):
            for source in sorted((self.root / top).rglob("*.*")):
                if source.suffix in (".h", ".cpp"):
                    self.look_at(source)
        for members in circles(self.edges):
            self.found.append("include one another in a circle: " + ", ".join(members))
        for folder, count in sorted(self.in_folder.items()):
            if count > MOST_FILES:
                self.found.append(f"{folder}: holds {count} files, more than {MOST_FILES}")

    def look_at(self, source):
        self.files += 1
        path = source.relative_to(self.root).as_posix()
        folder = folder_of(path)
        if folder is None:
            self.found.append(f"{path}: lies in no folder of the design")
            return
        self.in_folder[path.rpartition("/")[0]] = self.in_folder.get(path.rpartition("/")[0], 0) + 1
        if any(VAGUE_NAME.search(part) for part in unit_of(path).split("/")):
            self.found.append(f"{path}: util, common and misc say nothing; name it after what it does")
        lines = source.read_text(encoding="utf-8").splitlines()
        is_product = folder not in ("tests", "tools/bench")
        if is_product and len(lines) > MOST_LINES:
            self.found.append(f"{path}: has {len(lines)} lines, more than {MOST_LINES}")
        self.edges.setdefault(unit_of(path), set())
        for number, line in enumerate(lines, 1):
            match = INCLUDE.match(line)
            if match:
                reason = complaint_about(path, match[1], match[2])
                if reason:
                    self.found.append(f"{path}:{number}: {match[2]}: {reason}")
                if match[1] == '"' and unit_of(match[2]) != unit_of(path):
                    self.edges[unit_of(path)].add(unit_of(match[2]))
            defined = DEFINED_TYPE.match(line) if is_product and path.endswith(".h") else None
            if defined:
                name = (path.split("/")[0], defined[1])
                if self.home.setdefault(name, path) != path:
                    self.found.append(
                        f"{path}:{number}: {defined[1]} is a type of {self.home[name]} too")


FORBIDDEN = [
    ("core/geometry/a.h", '#include "core/raster/image.h"'),
    ("core/raster/a.cpp", '#include "core/files/results.h"'),
    ("core/files/a.cpp", '#include "core/raster/image.h"'),
    ("core/files/a.cpp", '#include "interior/interior.h"'),
    ("core/base/a.h", '#include "core/geometry/pose.h"'),
    ("interior/a.cpp", '#include "exterior/steps/align.h"'),
    ("interior/a.cpp", '#include "patchdb/store/patch.h"'),
    ("interior/marks/a.cpp", '#include "interior/locators/locator.h"'),
    ("interior/constellation/a.cpp", '#include "interior/interior.h"'),
    ("exterior/a.cpp", '#include "interior/interior.h"'),
    ("exterior/steps/a.cpp", '#include "exterior/search/wide_search.h"'),
    ("exterior/search/a.cpp", '#include "block/block.h"'),
    ("block/bundle/a.cpp", '#include "block/stages/tie_stage.h"'),
    ("block/a.cpp", '#include "tools/commands/progress.h"'),
    ("patchdb/store/a.h", '#include "exterior/steps/align.h"'),
    ("patchdb/store/a.h", '#include "patchdb/harvest/harvest.h"'),
    ("exterior/a.cpp", '#  include "tools/commands/command.h"'),
    ("interior/a.h", '#include "tests/support/shared_data.h"'),
    ("interior/a.h", '#include "neighbour.h"'),
    ("tools/a.cpp", ""),
    ("exterior/a.cpp", "#include <SQLiteCpp/Database.h>"),
    ("patchdb/harvest/a.cpp", "#include <SQLiteCpp/Database.h>"),
    ("tools/commands/a.cpp", "#include <sqlite3.h>"),
    ("interior/a.cpp", "#include <opencv2/core.hpp>"),
    ("core/raster/a.h", "#include <opencv2/core.hpp>"),
    ("tools/report/a.cpp", "#include <opencv2/core.hpp>"),
    ("interior/a.cpp", "#include <gdal_priv.h>"),
    ("exterior/a.cpp", "#include <ogr_spatialref.h>"),
    ("interior/a.cpp", "#include <ceres/ceres.h>"),
    ("core/geometry/a.cpp", "#include <toml++/toml.h>"),
    ("block/a.cpp", "#include <CLI/CLI.hpp>"),
    ("exterior/a.cpp", "#include <boost/optional.hpp>"),
    ("tests/interior/a_test.cpp", '#include "tests/exterior/scene.h"'),
    ("interior/utils.h", ""),
    ("interior/image_util.cpp", ""),
    ("interior/long.cpp", "\n" * 400),
]
ALLOWED = [
    ("core/geometry/a.cpp", "#include <ceres/ceres.h>"),
    ("core/terrain/a.cpp", "#include <ogr_spatialref.h>"),
    ("core/raster/a.cpp", "#include <opencv2/core.hpp>"),
    ("tools/bench/a.cpp", "#include <opencv2/features2d.hpp>"),
    ("core/files/a.cpp", '#include "core/geometry/pose.h"'),
    ("core/files/a.cpp", "#include <sys/stat.h>"),
    ("interior/a.cpp", '#include "core/raster/image.h"'),
    ("interior/a.cpp", '#include "core/base/error.h"'),
    ("interior/orientation/a.cpp", '#include "interior/marks/symbols.h"'),
    ("exterior/a.cpp", '#include "patchdb/store/patch.h"'),
    ("exterior/search/a.cpp", '#include "exterior/steps/predict.h"'),
    ("patchdb/store/a.cpp", "#include <SQLiteCpp/Database.h>"),
    ("tools/commands/a.cpp", '#include "exterior/orient_photo.h"'),
    ("tests/tools/report/a_test.cpp", '#include "tests/support/shared_data.h"'),
    ("tests/tools/report/a_test.cpp", '#include "tests/tools/scene.h"'),
    ("core/files/a.cpp", "// #include <opencv2/core.hpp> would be wrong here"),
    ("core/files/a.cpp", "#include <vector>"),
]


def complaints_of(sources):
    """Complaints about a source tree of these files: {path: text}."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in sources.items():
            file = pathlib.Path(root) / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text + "\n", encoding="utf-8")
        return SourceTree(root).found


def check_one(path, line):
    return complaints_of({path: "#pragma once\n" + line})


def what_is_missed():
    circle = {"interior/a.h": '#include "interior/b.h"', "interior/b.cpp": '#include "interior/a.h"'}
    twins = {"interior/a.h": "struct Peak {\n};", "interior/marks/a.h": "struct Peak {\n};"}
    crowd = {f"interior/a{i}.h": "" for i in range(MOST_FILES + 1)}
    missed = [what for what, sources in (("a circle", circle), ("two types of one name", twins),
                                         ("a crowded folder", crowd))
              if len(complaints_of(sources)) != 1]
    return missed + [f"{path} {line}" for path, line in FORBIDDEN if not check_one(path, line)]


def self_test():
    wrong = [f"missed: {what}" for what in what_is_missed()]
    wrong += [f"refused: {path} {line}" for path, line in ALLOWED if check_one(path, line)]
    print("\n".join(wrong) or f"{len(FORBIDDEN) + 3} faults found, {len(ALLOWED)} allowed")
    return 1 if wrong else 0


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    if len(arguments) != 1:
        print(__doc__)
        return 2
    tree = SourceTree(arguments[0])
    if tree.files == 0:
        tree.found.append(f"{arguments[0]}: no sources found; is this the project's root?")
    print("\n".join(tree.found) or f"{tree.files} files follow the table")
    return 1 if tree.found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
