#!/usr/bin/env python3
"""CTest `patchdb_hostile`: damaged and hostile patch databases never crash, hang, or escape.

    patchdb_hostile_test.py ORIENT [INPUTS]   INPUTS: 300 unless told; about 3 s each

Truncated and overwritten files, wrong types in columns, huge sizes, NaN coordinates, SQL in names,
circles of references. Every command on them ends by itself with exit code 0, 1 or 2, and leaves no
file anywhere but the database's own.
"""

import pathlib
import random
import struct
import subprocess
import sys
import tempfile

import patchdb_made_up

NAN_POINT = patchdb_made_up.point(float("nan"), float("inf"), -1e300)
HUGE_PNG = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", 0x7FFFFFFF, 0x7FFFFFFF, 16, 2,
                                               0, 0, 0) + b"\0" * 40
VALUES = [None, -1, 0, 2**31, 2**63 - 1, -2**63, 1e308, float("inf"), "text", "", "x" * 100000, b"",
          b"\0" * 7, b"\xff" * 100000, NAN_POINT, HUGE_PNG, "'; DROP TABLE patches; --", "../../../x",
          "%s%n%x", "\u202e\U0001f600", "2020-99-99"]


def rows(raw, random_):
    """A random value in a random column of a random table."""
    tables = ["patches", "sources", "attempts", "evidence", "gpkg_contents", "gpkg_geometry_columns",
              "gpkg_spatial_ref_sys", "orient_schema", "rtree_patches_geom"]
    for _ in range(random_.choice([1, 1, 1, 5])):
        table = random_.choice(tables)
        column = random_.choice([row[1] for row in raw.execute(f"PRAGMA table_info({table})")])
        where = random_.choice(["", " WHERE rowid % 3 = 0", " WHERE rowid = 5"])
        try:
            raw.execute(f"UPDATE {table} SET {column} = ?{where}", (random_.choice(VALUES),))
        except Exception:  # the database itself refuses some
            pass


def schema(raw, random_):
    """Tables that are not what they were."""
    statement = random_.choice([
        "DROP TABLE attempts", "DROP TABLE sources", "DELETE FROM orient_schema",
        "ALTER TABLE patches RENAME COLUMN chip TO chop", "DROP TABLE rtree_patches_geom",
        "DELETE FROM gpkg_geometry_columns", "DELETE FROM gpkg_spatial_ref_sys",
        "INSERT INTO orient_schema VALUES (99, 'future')", "PRAGMA application_id = 1",
        "ALTER TABLE evidence RENAME TO proof; CREATE VIEW evidence AS SELECT * FROM evidence",
        "CREATE TRIGGER t AFTER UPDATE ON patches BEGIN UPDATE patches SET epoch = epoch + 1; END",
        "UPDATE patches SET state = 'retired', superseded_by = id % 20 + 1",
        "INSERT INTO rtree_patches_geom SELECT id + 1000000, minx, maxx, miny, maxy FROM "
        "rtree_patches_geom"])
    try:
        raw.executescript(statement)
    except Exception:
        pass


def damage(source, path, random_):
    data = bytearray(source)
    kind = random_.randrange(5)
    if kind == 0:
        data = data[:random_.randrange(len(data))]
    elif kind == 1:
        for _ in range(random_.choice([1, 20, 2000])):
            data[random_.randrange(len(data))] = random_.randrange(256)
    elif kind == 2:
        start = random_.randrange(len(data))
        data[start:start + 4096] = bytes(random_.randrange(256) for _ in range(4096))
    path.write_bytes(data)
    if kind < 3:
        return
    raw = patchdb_made_up.open_raw(path)
    raw.execute("PRAGMA ignore_check_constraints = ON")
    (rows if kind == 3 else schema)(raw, random_)
    raw.commit()
    raw.close()


def main(orient, inputs):
    random_ = random.Random(20250417)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        whole = patchdb_made_up.other(orient, folder, 0, sources=3, patches=8)
        source = whole.read_bytes()
        path, target = folder / "hostile.gpkg", folder / "target.gpkg"
        codes = {}
        for number in range(inputs):
            for leftover in folder.glob("hostile.gpkg*"):
                leftover.unlink()
            damage(source, path, random_)
            target.write_bytes(source)
            before = {entry.name for entry in folder.iterdir()}
            for words in (["info", path], ["list", path],
                          ["query", path, "--box", 0, 0, 1e7, 1e7], ["stats", path],
                          ["check", path], ["merge", target, path], ["check", path, "--repair"],
                          ["retire", path, "--min-failures", "1", "--apply"], ["check", target]):
                done = subprocess.run([orient, "patchdb", *map(str, words)], capture_output=True,
                                      timeout=60, check=False, cwd=folder)
                assert done.returncode in (0, 1, 2), \
                    f"input {number}, {words}: exit {done.returncode}: {done.stderr}"
                codes[done.returncode] = codes.get(done.returncode, 0) + 1
            # A merge takes whole sources or nothing, and the target stays sound but for what the
            # damaged file truly says (checked by the last command's exit code above).
            after = {entry.name for entry in folder.iterdir()
                     if not entry.name.endswith(("-wal", "-shm", "-journal"))}
            assert after <= before, f"input {number}: files {after - before} appeared"
        print(f"{inputs} inputs, {sum(codes.values())} runs, exit codes {codes}")


if __name__ == "__main__":
    main(str(pathlib.Path(sys.argv[1]).resolve()),
         int(sys.argv[2]) if len(sys.argv) > 2 else 300)
