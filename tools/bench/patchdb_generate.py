#!/usr/bin/env python3
"""A large patch database for patchdb_speed, with the chips of a real one.

    patchdb_generate.py REAL.gpkg NEW.gpkg COUNT [BYTES]

NEW is made empty by `orient patchdb create`; it gets COUNT patches, COUNT / 25 km2 wide, in sources of
1000 neighbours, each with chip, heights and qualities of a patch of REAL (a harvest of real photos).
With BYTES chips are cut to that length (they do not decode then): for sizes that the disk does not
hold. Prints the file's size and that of the chips.
"""

import math
import os
import random
import sqlite3
import struct
import sys

COPIED = ("gsd_m, bits, bands, covariance, height_effect, height_sigma_m, roundness, distinctness, "
          "second_peak_px, persistence, relief_px, lean_px, energy_xx, energy_xy, energy_yy, quality, "
          "heights_size, heights_step_m, heights_base_m, heights_quantum_m, heights, chip_mask, chip")


def main(real, new, count, cut):
    models = sqlite3.connect(real).execute(f"SELECT {COPIED} FROM patches LIMIT 3000").fetchall()
    if cut:
        models = [model[:-1] + (model[-1][:cut],) for model in models]
    raw = sqlite3.connect(new, isolation_level=None)
    raw.execute("PRAGMA journal_mode = OFF")
    raw.execute("PRAGMA synchronous = OFF")
    raw.execute("PRAGMA cache_size = -400000")
    for name, at in (("ST_MinX", 13), ("ST_MaxX", 13), ("ST_MinY", 21), ("ST_MaxY", 21)):
        raw.create_function(name, 1, lambda blob, at=at: struct.unpack_from("<d", blob, at)[0])
    raw.create_function("ST_IsEmpty", 1, lambda blob: 0)
    srs = raw.execute("SELECT srs_id FROM gpkg_geometry_columns").fetchone()[0]
    random_ = random.Random(1)
    side = math.sqrt(40 * 1e6)  # of a source: 1000 patches at 25 a km2
    columns = math.ceil(math.sqrt(count / 1000))
    chips = 0
    raw.execute("BEGIN")
    places = ", ".join("?" * (2 + len(models[0])))
    for source in range(1, count // 1000 + 1):
        raw.execute("INSERT INTO sources (id, kind, name, gsd_m) VALUES (?, 'photo', ?, 0.25)",
                    (source, f"{source}.tif"))
        west = 500000 + side * ((source - 1) % columns)
        south = 5000000 + side * ((source - 1) // columns)
        for _ in range(1000):
            model = random_.choice(models)
            chips += len(model[-1])
            geom = (b"GP\0\1" + struct.pack("<iBIddd", srs, 1, 1001, west + side * random_.random(),
                                            south + side * random_.random(), 100.0))
            raw.execute(f"INSERT INTO patches (geom, source_id, {COPIED}) VALUES ({places})",
                        (geom, source, *model))
    extent = raw.execute("SELECT min(minx), min(miny), max(maxx), max(maxy) FROM "
                         "rtree_patches_geom").fetchone()
    raw.execute("UPDATE gpkg_contents SET min_x = ?, min_y = ?, max_x = ?, max_y = ? WHERE table_name "
                "= 'patches'", extent)
    raw.execute("COMMIT")
    raw.close()
    size = os.path.getsize(new)
    print(f"{count} patches, {size / 1e6:.1f} MB, chips {chips / 1e6:.1f} MB: "
          f"{size / chips:.2f} x the chips")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 0)
