#!/usr/bin/env python3
"""Time for the report and the GeoPackage of a large block, and their size.

    large_report.py ORIENT OUT FOLDER [TIMES]     OUT: the finished output folder of a block of
                                                  digital photos; FOLDER: for the large block

Lays out TIMES copies of the block (default 834: 10,008 photos from twelve), each with its own
photos, ties and control, and runs `orient report` on the large block. Pictures of patches are
linked, not copied. Prints the time, the memory, and the sizes of the files that a reader opens.
"""
import copy
import csv
import json
import math
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import time


def moved(point, by):
    return [point[0] + by[0], point[1] + by[1], *point[2:]]


def move_poses(node, by):
    """Moves all poses in a result: from the block, from the photo alone, and the approximation."""
    if isinstance(node, dict):
        if {"x", "y", "kappa"} <= node.keys():
            node["x"] += by[0]
            node["y"] += by[1]
        for value in node.values():
            move_poses(value, by)


def copy_of_photo(photo, number, by):
    new = copy.deepcopy(photo)
    new["photo"] = name_of(photo["photo"], number)
    move_poses(new, by)
    new["footprint"] = [moved(p, by) for p in photo["footprint"]]
    for patch in new["patches"]:
        if patch.get("ground"):
            patch["ground"] = moved(patch["ground"], by)
    return new


def copy_of_point(point, number, ids, by):
    new = copy.deepcopy(point)
    new["id"] = point["id"] + number * ids
    for key in ("ground", "given"):
        if new.get(key):
            new[key] = moved(new[key], by)
    for seen in new["seen"]:
        seen["photo"] = name_of(seen["photo"], number)
    return new


def name_of(photo, number):
    return f"{photo}_{number:05d}"


def enlarge(out, folder, times):
    photos = [json.loads(p.read_text()) for p in sorted(out.glob("*.exterior.json"))]
    xs, ys = ([p["pose"][axis] for p in photos] for axis in "xy")
    step = (1.3 * (max(xs) - min(xs)) + 500, 1.3 * (max(ys) - min(ys)) + 500)
    across = math.ceil(math.sqrt(times))
    block = json.loads((out / "block.json").read_text())
    ids = 1 + max(p["id"] for key in ("ties", "control") for p in block[key])
    large = {**block, "ties": [], "control": []}
    large["parts"] = [{**block["parts"][0], "photos": []}]
    with open(out / "orientation.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    with open(folder / "orientation.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(header)
        for number in range(times):
            by = (step[0] * (number % across), step[1] * (number // across))
            for photo in photos:
                new = copy_of_photo(photo, number, by)
                name = new["photo"]
                (folder / f"{name}.exterior.json").write_text(json.dumps(new))
                picture = out / f"{photo['photo']}.patches.png"
                if picture.exists():
                    os.link(picture, folder / f"{name}.patches.png")
                large["parts"][0]["photos"].append(name)
            for key in ("ties", "control"):
                large[key] += [copy_of_point(p, number, ids, by) for p in block[key]]
            for name, x, y, *rest in rows:
                table.writerow(
                    [name_of(name, number), f"{float(x) + by[0]:.4f}", f"{float(y) + by[1]:.4f}", *rest]
                )
    (folder / "block.json").write_text(json.dumps(large))
    for name in ("run.json", "orientation.prj", "block_camera.toml"):
        shutil.copy(out / name, folder / name)
    return len(photos) * times


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    orient, out, folder = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    folder.mkdir()
    photos = enlarge(out, folder, int(sys.argv[4]) if len(sys.argv) > 4 else 834)
    begin = time.time()
    subprocess.run([orient, "report", folder], check=True, stdout=subprocess.DEVNULL)
    seconds = time.time() - begin
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    sizes = {name: (folder / name).stat().st_size / 1e6 for name in ("report.html", "block.gpkg")}
    pages = list(folder.glob("report*/**/*.html"))
    print(
        f"{photos} photos: {seconds:.0f} s ({used.ru_utime + used.ru_stime:.0f} s of processor), "
        f"{used.ru_maxrss / 1024:.0f} MB; report.html {sizes['report.html']:.2f} MB, "
        f"{len(pages)} more pages of at most "
        f"{max((p.stat().st_size for p in pages), default=0) / 1e6:.2f} MB; "
        f"block.gpkg {sizes['block.gpkg']:.0f} MB"
    )


if __name__ == "__main__":
    main()
