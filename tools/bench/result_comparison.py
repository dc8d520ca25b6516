"""The comparison of compare_results.py: what counts as a difference between files of two builds."""

import csv
import itertools
import json
import math
import re
import sqlite3
import struct
import tomllib

from result_jobs import CONSOLE

# Keys, columns and tables by their content.
TEXTS = re.compile(r"messages?|(retired_)?reason|notes?|description|style\w*|identifier|command",
                   re.IGNORECASE)
# Inputs that a result was made from: digests of any form.
PROVENANCE = "made_from"
TIMES = {"last_change", "created", "added", "recorded", "retired_on", "update_time"}
RELATIVE = re.compile(r"(^|_)sigma|k1$|^[kp][123]?$|^correction$|in_lens|taken_out")
PROGRESS = re.compile(r"\d+ of \d+, \d+ %")
FREE_TABLES = re.compile(r"rtree_|sqlite_|orient_content$|orient_schema$|gpkg_extensions$")
DIGEST = re.compile(r"[0-9a-f]{16}$")
NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")
PICTURES = {".png", ".html"}
LARGEST_SCALE = 1000
SHOWN = 12  # differences per file


def numeric(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def number_of(text):
    try:
        return float(text)
    except ValueError:
        return None


class Comparison:
    """Compares one file after the other; differences, notes and messages are kept by file name."""

    def __init__(self, tolerance, roots):
        self.tolerance = tolerance
        self.roots = roots  # for A and B: folders at the beginning of paths
        self.differences, self.notes, self.messages = {}, {}, {}
        self.file = ""
        self.numbers = 0
        self.largest = (0.0, "")

    def add(self, kind, text):
        kind.setdefault(self.file, []).append(text)

    def differ(self, place, a, b):
        self.add(self.differences, f"{place}: {short(a)} -> {short(b)}")

    def message(self, place, a, b):
        self.add(self.messages, f"{place}: {short(a, 300)} -> {short(b, 300)}")

    def number(self, place, a, b, scale=1.0):
        """`scale`: the least size that the numbers count as; 0: their own size."""
        self.numbers += 1
        if a == b or (math.isnan(a) and math.isnan(b)):
            return
        size = max(abs(a), abs(b))
        by = abs(a - b) / (max(min(size, LARGEST_SCALE), scale) if scale else size)
        if by > self.largest[0]:
            self.largest = (by, f"{self.file} {place}")
        if not by <= self.tolerance:  # infinity and NaN differ, too
            self.differ(place, a, b)

    def neutral(self, side, text):
        for root, name in self.roots[side]:
            text = text.replace(root, name)
        return text

    def text(self, place, key, a, b):
        a, b = self.neutral(0, a), self.neutral(1, b)
        if a == b:
            return
        if TEXTS.fullmatch(key) or (DIGEST.match(a) and DIGEST.match(b)):
            self.message(place, a, b)
        else:
            self.differ(place, a, b)

    def value(self, place, key, a, b):
        if TEXTS.fullmatch(key):
            if a != b:
                self.text(place, key, json.dumps(a), json.dumps(b))
        elif numeric(a) and numeric(b):
            self.number(place, a, b, 0 if RELATIVE.search(key) else 1)
        elif isinstance(a, dict) and isinstance(b, dict):
            self.fields(place, key, a, b)
        elif isinstance(a, list) and isinstance(b, list):
            self.list(place, key, a, b)
        elif isinstance(a, str) and isinstance(b, str):
            self.text(place, key, a, b)
        elif isinstance(a, bytes) and isinstance(b, bytes):
            self.blob(place, key, a, b)
        elif a != b or type(a) is not type(b):
            self.differ(place, a, b)

    def fields(self, place, key, a, b):
        if key == "not_visible":  # counts by the reason's text
            self.number(f"{place}.not_visible", sum(a.values()), sum(b.values()))
            if a != b:
                self.message(place, a, b)
            return
        for name in a:
            if name in TIMES:
                continue
            if name == PROVENANCE:
                if a[name] != b.get(name):
                    self.message(f"{place}.{name}", a[name], b.get(name))
            elif name in b:
                self.value(f"{place}.{name}" if place else name, name, a[name], b[name])
            else:
                self.add(self.differences, f"{place}.{name}: the field is not there any more")
        for name in sorted(b.keys() - a.keys()):
            self.add(self.notes, f"{re.sub(r'[0-9]+', 'i', place)}.{name}: a new field")

    def list(self, place, key, a, b):
        if len(a) != len(b):
            self.differ(place, f"{len(a)} elements", f"{len(b)} elements")
        elif key == "covariance" and all(isinstance(r, list) and len(r) == len(a) for r in a + b):
            self.covariance(place, a, b)
        else:
            for i, (x, y) in enumerate(zip(a, b)):
                self.value(f"{place}[{i}]", key, x, y)

    def covariance(self, place, a, b):
        """A square matrix; each element is compared relative to its two standard deviations."""
        sigma = [math.sqrt(max(abs(a[i][i]), abs(b[i][i]))) for i in range(len(a))]
        for i, row in enumerate(a):
            for k, value in enumerate(row):
                scale = sigma[i] * sigma[k]
                self.number(f"{place}[{i}][{k}]", value / scale if scale else value,
                            b[i][k] / scale if scale else b[i][k])

    def blob(self, place, key, a, b):
        if a == b:
            self.numbers += 1
        elif len(a) != len(b):
            self.differ(place, f"{len(a)} bytes", f"{len(b)} bytes")
        elif a[:2] == b"GP":
            self.value(place, "geom", geometry(a), geometry(b))
        elif key in ("covariance", "height_effect"):
            lists = [struct.unpack(f"<{len(x) // 8}d", x) for x in (a, b)]
            largest = max(map(abs, lists[0] + lists[1])) or 1
            for i, (x, y) in enumerate(zip(*lists)):
                self.number(f"{place}[{i}]", x / largest, y / largest)
        else:
            self.add(self.differences, f"{place}: other bytes")

    # Files

    def compare(self, name, a, b):
        self.file = name
        if a.suffix in PICTURES:
            if a.read_bytes() != b.read_bytes():
                self.message("page or picture", f"{a.stat().st_size} bytes", f"{b.stat().st_size}")
        elif a.name == CONSOLE:
            self.console(a, b)
        elif a.suffix == ".json":
            self.value("", "", *(json.loads(path.read_text(encoding="utf-8")) for path in (a, b)))
        elif a.suffix == ".toml":
            self.toml(a, b)
        elif a.suffix == ".csv":
            self.csv(a, b)
        elif a.suffix == ".gpkg":
            self.value("", "", tables(a), tables(b))
        elif b"\0" in a.read_bytes()[:4096]:
            if a.read_bytes() != b.read_bytes():
                self.differ("other bytes", *(f"{path.stat().st_size} bytes" for path in (a, b)))
        else:
            self.words(a, b)

    def toml(self, a, b):
        texts = [path.read_text(encoding="utf-8") for path in (a, b)]
        self.value("", "", *map(tomllib.loads, texts))
        comments = [[line for line in text.splitlines() if line.startswith("#")] for text in texts]
        if comments[0] != comments[1]:
            self.message("comments", *comments)

    def console(self, a, b):
        lines = [[line for line in self.neutral(side, path.read_text(encoding="utf-8")).splitlines()
                  if not PROGRESS.search(line)] for side, path in enumerate((a, b))]
        for i, (x, y) in enumerate(itertools.zip_longest(*lines, fillvalue=""), 1):
            if x != y:
                self.message(f"line {i}", x, y)

    def csv(self, a, b):
        tables_of = [rows_of(path) for path in (a, b)]
        if not all(tables_of):
            self.words(a, b)
        elif a.name == "pose_covariance.csv":  # two columns of names precede the matrix
            names = [[list(row.values())[:2] for row in rows] for rows in tables_of]
            self.value("row", "", *names)
            if names[0] == names[1]:
                self.covariance("", *([list(row.values())[2:] for row in rows]
                                      for rows in tables_of))
        else:
            self.value("row", "", *tables_of)

    def words(self, a, b):
        """Compares numbers and the text between them by lines; lines with # are comments."""
        lines = [self.neutral(side, path.read_text(encoding="utf-8")).splitlines()
                 for side, path in enumerate((a, b))]
        if len(lines[0]) != len(lines[1]):
            self.differ("lines", len(lines[0]), len(lines[1]))
            return
        for i, (x, y) in enumerate(zip(*lines), 1):
            if x == y:
                self.numbers += len(NUMBER.findall(x))
            elif NUMBER.sub("", x) != NUMBER.sub("", y) or not NUMBER.search(x):
                (self.message if x.startswith("#") else self.differ)(f"line {i}", x, y)
            else:
                for k, (p, q) in enumerate(zip(NUMBER.findall(x), NUMBER.findall(y)), 1):
                    self.number(f"line {i}, number {k}", float(p), float(q))

    def report(self, with_messages):
        def count(kind):
            return sum(map(len, kind.values()))
        messages = self.messages if with_messages else {}
        for title, kind, limit in (("differs", self.differences, SHOWN),
                                   ("note", self.notes, SHOWN),
                                   ("message", messages, None)):
            for name, texts in sorted(kind.items()):
                distinct = list(dict.fromkeys(texts))
                for text in distinct[:limit]:
                    print(f"{title:8} {name}  {text}")
                if limit and len(distinct) > limit:
                    print(f"{title:8} {name}  ... and {len(distinct) - limit} more")
        where = f", {self.largest[1]}" if self.largest[1] else ""
        print(f"{self.numbers} numbers compared; largest difference, of a number's size: "
              f"{self.largest[0]:.2g}{where}")
        print(f"{count(self.differences)} differences in {len(self.differences)} files; "
              f"{count(self.notes)} notes; {count(self.messages)} messages, digests or pictures")


def short(value, length=80):
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= length else text[:length] + " ..."


def cell_of(text):
    number = number_of(text)
    return text if number is None or DIGEST.match(text) else number


def rows_of(path):
    """Rows of a table with a header, as dicts; empty if it has no header."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines()
             if line and not line.startswith("#")]
    header, *rows = csv.reader(lines) if lines else [[]]
    if len(header) < 2 or any(number_of(cell) is not None for cell in header):
        return []
    return [dict(itertools.zip_longest(header, map(cell_of, row))) for row in rows]


def geometry(blob):
    """The numbers of a GeoPackage geometry; little-endian points, lines and polygons."""
    at = 8 + {0: 0, 1: 32, 2: 48, 3: 48, 4: 64}[(blob[3] >> 1) & 7]
    kind = struct.unpack_from("<I", blob, at + 1)[0]
    numbers = [struct.unpack_from("<i", blob, 4)[0], kind]
    size, at = 3 if kind > 1000 else 2, at + 5

    def counted():
        nonlocal at
        at += 4
        return struct.unpack_from("<I", blob, at - 4)[0]
    rings = counted() if kind % 1000 == 3 else 1
    for _ in range(rings):
        points = 1 if kind % 1000 == 1 else counted()
        numbers += struct.unpack_from(f"<{size * points}d", blob, at)
        at += 8 * size * points
    return numbers


def tables(path):
    """{table: rows as dicts}, without indexes and tables of times and tokens."""
    database = sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True)
    database.row_factory = sqlite3.Row
    names = [row[0] for row in
             database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
    found = {name: [dict(row) for row in database.execute(f'SELECT * FROM "{name}"')]
             for name in names if not FREE_TABLES.match(name)}
    database.close()
    return found
