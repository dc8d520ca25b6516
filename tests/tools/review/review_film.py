"""Real film frames on the page of `orient review`."""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import time

from review_server import running


def real_film():
    """The folder of real frames; None if it is absent."""
    root = pathlib.Path(__file__).resolve().parents[3]
    film = pathlib.Path(os.environ.get("ORIENT_SHARED_DATA", root / "../shared/data")) / "film"
    if film.is_dir():
        return film
    print("not tried on real frames: real data absent (ORIENT_SHARED_DATA): film")
    return None


def click_mark(page, mark, pixel):
    """Names a mark and clicks it to a whole pixel, as a person without a camera file does."""
    page.type("mark", mark)
    page.at("measure").click()
    page.browser.execute_script(
        "photoView.map.setView(photoView.placeOf(arguments[0]), 2, {animate: false})", list(pixel))
    page.press(page.keys.ENTER)
    page.said(f"Saved: mark {mark} of photo {page.text('name')}")


def a_camera_from_clicks(page, orient, folder, pictures):
    """A camera not in any library, from one scan; with it, the roll's other frame is oriented."""
    film = real_film()
    if not film:
        return
    library, out, said = folder / "library", folder / "unknown", folder / "clicks"
    library.mkdir()
    shutil.copy(pathlib.Path(__file__).resolve().parents[3] / "data/cameras/wild_18cm.toml", library)
    scan, other = film / "0c8e8831.jpg", film / "5bdd5cf4.jpg"
    subprocess.run([orient, "interior", scan, other, "--camera", "auto", "--camera-library", library,
                    "--out", out], check=False, capture_output=True)
    with open(film / "marks.csv", encoding="utf-8") as file:
        hand = [row for row in csv.DictReader(file)
                if row["frame"] == "0c8e8831" and len(row["mark"]) == 2]
    with running(orient, out, scan, other, "--measurements", said) as server:
        begun = time.monotonic()
        page.open(server.address)
        page.browser.execute_script("return choose('0c8e8831')")
        page.until(lambda: page.text("name") == "0c8e8831", "the frame")
        assert page.text("status") == "failed"
        for row in hand:
            click_mark(page, row["mark"], (round(float(row["col_px"])), round(float(row["row_px"]))))
        clicked = time.monotonic()
        page.picture(pictures, "new_camera_clicks")
        assert not page.errors() and not page.foreign_requests()
    made = folder / "made.toml"
    subprocess.run([orient, "cameras", "new", scan, "--measurements", said, "--pixel-size-um", "127",
                    "--principal-distance-mm", "152.75", "--out", made], check=True,
                   capture_output=True)
    print(f"a new camera: {len(hand)} marks clicked in {clicked - begun:.1f} s, "
          f"made in {time.monotonic() - clicked:.1f} s")
    subprocess.run([orient, "interior", other, "--camera", made, "--scanner", "desktop", "--out",
                    folder / "read"], check=True, capture_output=True)
    result = json.loads((folder / "read/5bdd5cf4.interior.json").read_text(encoding="utf-8"))
    assert result["status"] == "ok", result["messages"]


def a_failed_frame_becomes_weak(page, orient, folder, pictures):
    """A curled print of a real film: three marks by eye (one of the four is not visible)."""
    film = real_film()
    if not film:
        return
    scan, root = film / "0cec8b13.jpg", pathlib.Path(__file__).resolve().parents[3]
    camera = ["--camera", root / "data/cameras/wild_rc8_23.toml"]
    subprocess.run([orient, "interior", scan, *camera, "--out", folder / "film"], check=False,
                   capture_output=True)
    with running(orient, folder / "film", scan, *camera, "--measurements", folder / "eye") as server:
        page.open(server.address)
        assert page.text("status") == "failed"
        for mark, pixel in (("1", (68.5, 1780.2)), ("3", (78.8, 84.3)), ("2", (1734.8, 103.6))):
            page.measure_by_keys(mark, pixel)
        page.press("d")
        page.said("Oriented again.")
        assert page.text("status") == "weak", page.text("reasons")
        page.picture(pictures, "film")
        assert not page.errors() and not page.foreign_requests()
