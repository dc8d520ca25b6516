#!/usr/bin/env python3
"""CTest `patchdb_hostile` (quick) and `patchdb_hostile_all` (slow): with damaged and hostile patch
databases, no command crashes, hangs, or writes elsewhere.

    hostile_test.py ORIENT [INPUTS [PROGRAM [FIRST]]]

INPUTS: number of inputs, default 5 (one of each kind); a few seconds each. PROGRAM: the program run
on them, default ORIENT; preferably one with sanitizers (preset `asan`), whose findings fail the
test. FIRST: number of the first input, default 0; every number is a different input.

The inputs are truncated and overwritten files, wrong types in columns, huge sizes, NaN coordinates,
SQL in names, and circular references. Every command on them must end by itself within a minute,
with exit code 0, 1 or 2, and leave no files other than the database's own. A database that they are
merged into must stay sound.
"""

import os
import pathlib
import random
import struct
import subprocess
import sys
import tempfile

import made_up

NAN_POINT = made_up.point(float("nan"), float("inf"), -1e300)
HUGE_PNG = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", 0x7FFFFFFF, 0x7FFFFFFF, 16, 2,
                                               0, 0, 0) + b"\0" * 40
VALUES = [None, -1, 0, 2**31, 2**63 - 1, -2**63, 1e308, float("inf"), "text", "", "x" * 100000, b"",
          b"\0" * 7, b"\xff" * 100000, NAN_POINT, HUGE_PNG, "'; DROP TABLE patches; --", "../../../x",
          "%s%n%x", "\u202e\U0001f600", "2020-99-99"]


SCRIPTS = [
    "DROP TABLE attempts", "DROP TABLE sources", "DELETE FROM orient_schema", "DELETE FROM sources",
    "ALTER TABLE patches RENAME COLUMN chip TO chop", "DROP TABLE rtree_patches_geom",
    "DELETE FROM gpkg_geometry_columns", "DELETE FROM gpkg_spatial_ref_sys", "DROP TABLE evidence",
    "INSERT INTO orient_schema VALUES (99, 'future')", "PRAGMA application_id = 1",
    "UPDATE orient_schema SET version = -version", "UPDATE orient_schema SET version = 'two'",
    "ALTER TABLE evidence RENAME TO proof; CREATE VIEW evidence AS SELECT * FROM evidence",
    "CREATE TRIGGER t AFTER UPDATE ON patches BEGIN UPDATE patches SET epoch = epoch + 1; END",
    "UPDATE patches SET state = 'retired', superseded_by = id % 20 + 1",
    "UPDATE patches SET state = 'retired', retired_reason = 'x', superseded_by = max(id - 1, 1)",
    "UPDATE patches SET superseded_by = id", "UPDATE patches SET superseded_by = 9223372036854775807",
    "UPDATE patches SET epoch = 9223372036854775807", "UPDATE patches SET epoch = -2147483648",
    "UPDATE attempts SET epoch = -9223372036854775808", "UPDATE patches SET chip = zeroblob(9000000)",
    "UPDATE patches SET heights = zeroblob(100000000), heights_size = 5000, heights_step_m = 1 "
    "WHERE id = 5",
    "UPDATE patches SET heights = zeroblob(36), heights_size = 2147483647, heights_step_m = 1",
    "UPDATE patches SET heights = zeroblob(36), heights_size = -3, heights_step_m = 9e999",
    "UPDATE patches SET covariance = zeroblob(47)",
    f"UPDATE patches SET covariance = x'{(struct.pack('<d', float('nan')) * 6).hex()}'",
    f"UPDATE patches SET geom = x'{NAN_POINT.hex()}'", f"UPDATE patches SET chip = x'{HUGE_PNG.hex()}'",
    "UPDATE patches SET gsd_m = 1e-300", "UPDATE patches SET gsd_m = 1e300",
    "UPDATE patches SET chip_mask = chip", "UPDATE patches SET height_effect = x'00'",
    "UPDATE sources SET name = '''; DROP TABLE patches; --' || id",
    "UPDATE sources SET kind = 'a''; DELETE FROM patches; --', name = '../../' || id",
    "UPDATE sources SET name = replace(hex(zeroblob(500000)), '0', 'x') || id",
    "UPDATE attempts SET photo = '''; DELETE FROM patches; --'", "UPDATE sources SET date = -1",
    "UPDATE gpkg_spatial_ref_sys SET definition = replace(hex(zeroblob(100000)), '00', 'PROJCS[')",
    "INSERT INTO rtree_patches_geom SELECT id + 1000000, minx, maxx, miny, maxy FROM "
    "rtree_patches_geom", "UPDATE rtree_patches_geom SET minx = -9e999, maxx = 9e999",
    "INSERT INTO evidence (patch_id, source_id, col_px) SELECT id, source_id, 'x' FROM patches",
    "DROP TABLE orient_content", "DELETE FROM orient_content", "DROP TRIGGER orient_content_update"]


def rows(raw, random_):
    """Writes a random value to a random column of a random table."""
    tables = ["patches", "sources", "attempts", "evidence", "gpkg_contents", "gpkg_geometry_columns",
              "gpkg_spatial_ref_sys", "orient_schema", "orient_content", "rtree_patches_geom",
              "layer_styles", "gpkg_metadata"]
    for _ in range(random_.choice([1, 1, 1, 5])):
        table = random_.choice(tables)
        column = random_.choice([row[1] for row in raw.execute(f"PRAGMA table_info({table})")])
        where = random_.choice(["", " WHERE rowid % 3 = 0", " WHERE rowid = 5"])
        try:
            raw.execute(f"UPDATE {table} SET {column} = ?{where}", (random_.choice(VALUES),))
        except Exception:  # SQLite itself refuses some
            pass


def script(raw, number):
    """Changes the tables themselves."""
    try:
        raw.executescript(SCRIPTS[number % len(SCRIPTS)])
    except Exception:  # as above
        pass


def damage(source, path, number, random_):
    """Damages the database. Kinds of damage alternate; `turn` counts within a kind."""
    data = bytearray(source)
    turn, kind = divmod(number, 5)
    if kind == 0:  # truncated, anywhere and around page boundaries
        places = [1, 15, 16, 99, 100, 101, 4095, 4096, 4097, len(data) - 4096, len(data) - 1]
        end = places[turn] if turn < len(places) else len(data) * (turn - 10) // 50 % len(data)
        data = data[:end]
    elif kind == 1:
        for _ in range([1, 20, 2000][turn % 3]):
            data[random_.randrange(len(data))] = random_.randrange(256)
    elif kind == 2:
        start = random_.randrange(len(data) // 4096) * 4096
        data[start:start + 4096] = random_.choice([random_.randbytes(4096), bytes(4096), data[:4096],
                                                   b"\xff" * 4096])
    path.write_bytes(data)
    if kind < 3:
        return
    raw = made_up.open_raw(path)
    raw.execute("PRAGMA ignore_check_constraints = ON")
    raw.execute("PRAGMA foreign_keys = OFF")
    if kind == 3:
        rows(raw, random_)
    else:
        script(raw, turn)
    raw.commit()
    raw.close()


def run(program, folder, number, words, sound=False):
    """The exit code. A sanitizer's finding has its own, which no command uses."""
    environment = {**os.environ, "UBSAN_OPTIONS": "halt_on_error=1:exitcode=99",
                   "ASAN_OPTIONS": "exitcode=99:detect_leaks=0:allocator_may_return_null=1"}
    done = subprocess.run([program, "patchdb", *map(str, words)], capture_output=True, timeout=60,
                          check=False, cwd=folder, env=environment)
    assert done.returncode in ((0,) if sound else (0, 1, 2)), \
        f"input {number}, {words}: exit {done.returncode}: {done.stdout}{done.stderr}"
    return done.returncode


def main(orient, inputs, program, first):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        whole = made_up.other(orient, folder, 0, sources=3, patches=8)
        source = whole.read_bytes()
        path, target = folder / "hostile.gpkg", folder / "target.gpkg"
        codes = {}
        for number in range(first, first + inputs):
            for leftover in [*folder.glob("hostile.gpkg*"), *folder.glob("target.gpkg*")]:
                leftover.unlink()
            damage(source, path, number, random.Random(20250417 + number))
            target.write_bytes(source)
            before = {entry.name for entry in folder.iterdir()}
            for words in (["info", path], ["list", path],
                          ["query", path, "--box", 0, 0, 1e7, 1e7], ["stats", path],
                          ["check", path], ["merge", target, path], ["update", target, path],
                          ["check", path, "--repair"],
                          ["retire", path, "--min-failures", "1", "--apply"]):
                code = run(program, folder, number, words)
                codes[code] = codes.get(code, 0) + 1
            # A merge takes complete sources or nothing.
            run(program, folder, number, ["check", target], sound=True)
            after = {entry.name for entry in folder.iterdir()
                     if not entry.name.endswith(("-wal", "-shm", "-journal"))}
            assert after <= before, f"input {number}: files {after - before} appeared"
            print(f"\r{number - first + 1} inputs", end="", file=sys.stderr, flush=True)
        print(f"inputs {first} to {first + inputs - 1}, {sum(codes.values())} runs, exit codes {codes}")


if __name__ == "__main__":
    ORIENT = str(pathlib.Path(sys.argv[1]).resolve())
    main(ORIENT, int(sys.argv[2]) if len(sys.argv) > 2 else 5,
         str(pathlib.Path(sys.argv[3]).resolve()) if len(sys.argv) > 3 else ORIENT,
         int(sys.argv[4]) if len(sys.argv) > 4 else 0)
