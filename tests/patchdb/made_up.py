"""Synthetic patch databases, made by writing rows, for tests that run the program from outside."""

import random
import sqlite3
import struct
import subprocess
import zlib


def run(orient, *words):
    done = subprocess.run([orient, *map(str, words)], capture_output=True, text=True, timeout=300,
                          check=False)
    assert done.returncode == 0, f"{words}: exit {done.returncode}: {done.stdout}{done.stderr}"
    return done.stdout


def create(orient, path):
    run(orient, "patchdb", "create", path, "--crs", "EPSG:32635")


def png(side, random_):
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data +
                struct.pack(">I", zlib.crc32(kind + data)))
    rows = b"".join(b"\0" + bytes(random_.randrange(256) for _ in range(side)) for _ in range(side))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def point(x, y, z):
    return b"GP\0\1" + struct.pack("<i", 32635) + struct.pack("<BIddd", 1, 1001, x, y, z)


def open_raw(path):
    raw = sqlite3.connect(path)
    raw.create_function("ST_MinX", 1, lambda blob: struct.unpack_from("<d", blob, 13)[0])
    raw.create_function("ST_MaxX", 1, lambda blob: struct.unpack_from("<d", blob, 13)[0])
    raw.create_function("ST_MinY", 1, lambda blob: struct.unpack_from("<d", blob, 21)[0])
    raw.create_function("ST_MaxY", 1, lambda blob: struct.unpack_from("<d", blob, 21)[0])
    raw.create_function("ST_IsEmpty", 1, lambda blob: 0)
    return raw


def give_old_pages(path):
    """Gives the file the page size of earlier versions of the program."""
    raw = sqlite3.connect(path, isolation_level=None)
    for change in ("journal_mode = DELETE", "page_size = 4096"):
        raw.execute(f"PRAGMA {change}")
    raw.execute("VACUUM")
    raw.execute("PRAGMA journal_mode = WAL")
    raw.close()


def other(orient, folder, number, sources=12, patches=25):
    """A separate database: each number shares half of its positions, and their appearance, with the
    number before."""
    path = folder / f"other-{number}.gpkg"
    create(orient, path)
    random_ = random.Random(number)
    with open_raw(path) as raw:
        for source in range(1, sources + 1):
            raw.execute("INSERT INTO sources (id, kind, name, date, gsd_m) VALUES (?, 'photo', ?, ?, "
                        "0.5)", (source, f"made-up-{number}-{source}.tif", str(1990 + number)))
            for patch in range(patches):
                x = 500000 + 40 * (patch + patches // 2 * number)
                look = random.Random(100 * x + source)
                added = raw.execute(
                    "INSERT INTO patches (geom, source_id, gsd_m, bits, covariance, chip) VALUES "
                    "(?, ?, 0.5, 8, ?, ?)",
                    (point(x, 5000000 + 50 * source, 100), source,
                     struct.pack("<6d", 1, 0, 0, 1, 0, 1), png(31, look)))
                raw.execute("INSERT INTO attempts (patch_id, photo, state, reason, photo_status) VALUES "
                            "(?, ?, ?, '', 'ok')", (added.lastrowid, f"photo-{number}",
                                                    random_.choice(["matched", "not_found"])))
    raw.close()
    run_quietly(orient, "patchdb", "check", path, "--repair")  # weights and extent
    run(orient, "patchdb", "check", path)
    return path


def run_quietly(orient, *words):
    subprocess.run([orient, *map(str, words)], capture_output=True, timeout=300, check=False)


def terrain(folder):
    """A level DEM at 100 m under everything created here."""
    path = folder / "dem.asc"
    row = " ".join(["100"] * 40)
    path.write_text("ncols 40\nnrows 40\nxllcorner 498000\nyllcorner 4998000\ncellsize 100\n"
                    "NODATA_value -9999\n" + f"{row}\n" * 40)
    path.with_suffix(".prj").write_text(
        'PROJCS["WGS_1984_UTM_Zone_35N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",'
        '6378137.0,298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],'
        'PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],'
        'PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",27.0],'
        'PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],UNIT["Meter",1.0]]')
    return path


def orthophoto(folder, number, side=600):
    """Overlaps with the next number by half. Raw bytes with an ENVI header, 0.5 m per pixel."""
    ground = random.Random(5)
    blocks = [[ground.randrange(40, 216) for _ in range(2 * side // 5)] for _ in range(side // 5)]
    rows = bytearray()
    for row in range(side):
        line = (blocks[row // 5][(column + number * side // 2) // 5] for column in range(side))
        rows += bytes(line)
    path = folder / f"ortho-{number}.img"
    path.write_bytes(rows)
    path.with_suffix(".hdr").write_text(
        f"ENVI\nsamples = {side}\nlines = {side}\nbands = 1\nheader offset = 0\ndata type = 1\n"
        "interleave = bsq\nbyte order = 0\n"
        f"map info = {{UTM, 1, 1, {499500 + number * side / 4}, 4999900, 0.5, 0.5, 35, North, WGS-84}}\n")
    return path
