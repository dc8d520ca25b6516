#!/usr/bin/env python3
"""A large patch database for patchdb_speed, with the chips of a real one.

    patchdb_generate.py REAL.gpkg NEW.gpkg COUNT [SIDE]

NEW is an empty database from `orient patchdb create`. It is filled with COUNT patches on an area of
COUNT / 25 km2, in sources of 1000 neighbours, each with the chip, heights and quality figures of a
patch of REAL (a harvest of real photos). With SIDE, chips are noise PNGs of that many pixels per
side, and heights are left out: for numbers of patches that the disk could not hold otherwise.
Prints the size of the file and of the chips.
"""

import math
import os
import random
import sqlite3
import struct
import sys
import zlib

COPIED = ("gsd_m, bits, bands, covariance, height_effect, height_sigma_m, roundness, distinctness, "
          "second_peak_px, persistence, relief_px, lean_px, energy_xx, energy_xy, energy_yy, quality, "
          "heights_size, heights_step_m, heights_base_m, heights_quantum_m, heights, chip_mask, chip")
PER_SOURCE = 1000
INDEX = "rtree_patches_geom"


def noise_png(side, random_):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    rows = b"".join(b"\0" + random_.randbytes(side) for _ in range(side))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def models_of(real, side):
    models = sqlite3.connect(real).execute(f"SELECT {COPIED} FROM patches LIMIT 3000").fetchall()
    if side:
        random_ = random.Random(2)
        models = [model[:-7] + (None,) * 6 + (noise_png(side, random_),) for model in models]
    return models


def patches(models, count, srs):
    """Rows of patches and of their index, one source at a time."""
    random_ = random.Random(1)
    side = math.sqrt(40 * 1e6)  # of a source, m: 1000 patches at 25 per km2
    columns = math.ceil(math.sqrt(count / PER_SOURCE))
    for source in range(1, count // PER_SOURCE + 1):
        west = 500000 + side * ((source - 1) % columns)
        south = 5000000 + side * ((source - 1) // columns)
        rows, index = [], []
        for number in range(PER_SOURCE):
            identity = (source - 1) * PER_SOURCE + number + 1
            x, y = west + side * random_.random(), south + side * random_.random()
            geom = b"GP\0\1" + struct.pack("<iBIddd", srs, 1, 1001, x, y, 100.0)
            rows.append((identity, geom, source, *random_.choice(models)))
            index.append((identity, x, x, y, y))
        yield source, rows, index


def main(real, new, count, side):
    models = models_of(real, side)
    raw = sqlite3.connect(new, isolation_level=None)
    for setting in ("journal_mode = OFF", "synchronous = OFF", "cache_size = -400000"):
        raw.execute(f"PRAGMA {setting}")
    srs = raw.execute("SELECT srs_id FROM gpkg_geometry_columns").fetchone()[0]
    # The index is filled here, not by the trigger, which would call Python for every coordinate.
    trigger = raw.execute("SELECT sql FROM sqlite_master WHERE name = ?", (f"{INDEX}_insert",))
    trigger = trigger.fetchone()[0]
    raw.execute(f"DROP TRIGGER {INDEX}_insert")
    raw.execute("BEGIN")
    places, chips = ", ".join("?" * (3 + len(models[0]))), 0
    for source, rows, index in patches(models, count, srs):
        raw.execute("INSERT INTO sources (id, kind, name, gsd_m) VALUES (?, 'photo', ?, 0.25)",
                    (source, f"{source}.tif"))
        raw.executemany(f"INSERT INTO patches (id, geom, source_id, {COPIED}) VALUES ({places})", rows)
        raw.executemany(f"INSERT INTO {INDEX} VALUES (?, ?, ?, ?, ?)", index)
        chips += sum(len(row[-1]) for row in rows)
    raw.execute(trigger)
    extent = raw.execute(f"SELECT min(minx), min(miny), max(maxx), max(maxy) FROM {INDEX}").fetchone()
    raw.execute("UPDATE gpkg_contents SET min_x = ?, min_y = ?, max_x = ?, max_y = ? WHERE table_name "
                "= 'patches'", extent)
    raw.execute("COMMIT")
    raw.close()
    size = os.path.getsize(new)
    print(f"{count} patches, {size / 1e6:.1f} MB, chips {chips / 1e6:.1f} MB: "
          f"{size / chips:.2f} x the chips")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 0)
