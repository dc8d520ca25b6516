#!/usr/bin/env python3
"""CTest `review_page` (slow): the page of `orient review` in a real browser, by mouse and by keys.

    review_page_test.py ORIENT [PICTURES]    PICTURES: folder for screenshots of what was seen

Needs Debian's chromium, chromium-driver and python3-selenium; is skipped (exit code 77) without.
A simulated block of three photos is oriented; on the page a mark is measured, a ground point is
taken from photo and map, a photo is placed in the map, decisions are made, taken back, withdrawn,
and carried out.
"""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from review_server import make_folder, running

SKIPPED = 77
DEBIAN_PYTHON = "/usr/bin/python3"  # whose package selenium is
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]


def make_block(orient, folder):
    def do(*words):
        subprocess.run([orient, *map(str, words)], check=True, capture_output=True)

    block = folder / "block"
    do("simulate", "--out", block, "--photos", 3, "--gsd-m", 1.5, "--pixel-size-um", 100,
       "--position-error-m", 3, "--attitude-error-deg", 0.5, "--ortho", "--bare")
    old = block / "old"
    do("patchdb", "create", block / "patches.gpkg", "--crs", "EPSG:32635")
    do("patchdb", "harvest", block / "patches.gpkg", "--camera", old / "camera.toml",
       "--orientation", old / "orientation.csv", "--interior", old / "interior",
       *sorted((old / "photos").glob("*.tif")), "--dem", block / "dem.tif", "--date", 1990,
       "--max-per-photo", 60)
    (block / "said").mkdir()
    (block / "said/decisions.csv").write_text("photo,decision,value,reason\n", encoding="utf-8")
    text = (block / "block.toml").read_text(encoding="utf-8")
    (block / "block.toml").write_text('measurements = "said"\n' + text, encoding="utf-8")
    do("block", block / "block.toml")
    return block


class Page:
    """What a person sees and does; every wait has an end."""

    def __init__(self, browser, keys, actions):
        self.browser, self.keys, self.actions = browser, keys, actions

    def open(self, address):
        self.browser.get(address)
        self.until(lambda: self.text("name") != "No photo", "a photo is shown")

    def until(self, true, what, seconds=60):
        end = time.monotonic() + seconds
        while not true():
            assert time.monotonic() < end, f"not seen: {what}; message: {self.text('message')}"
            time.sleep(0.1)

    def at(self, name):
        return self.browser.find_element("id", name)

    def text(self, name):
        return self.browser.execute_script(
            f"const e = document.getElementById('{name}'); return e.hidden ? '' : e.textContent")

    def press(self, *keys):
        self.actions(self.browser).send_keys(*keys).perform()

    def type(self, name, text):
        self.at(name).clear()
        self.at(name).send_keys(text)

    def click_stage(self, name, dx=0, dy=0):
        self.actions(self.browser).move_to_element_with_offset(self.at(name), dx, dy).click().perform()

    def said(self, text):
        self.until(lambda: self.text("message") == text, text)

    def script(self, text):
        return self.browser.execute_script("return " + text)

    def errors(self):
        return [entry for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]

    def foreign_requests(self):
        return self.script("performance.getEntries().map((e) => e.name).filter((n) => "
                           "n.includes('://') && !n.startsWith(location.origin + '/'))")

    def picture(self, folder, name):
        if folder:
            self.browser.save_screenshot(str(folder / f"{name}.png"))


def looks_and_moves(page, names, pictures):
    photos = page.browser.find_elements("css selector", "#photos button")
    assert len(photos) == len(names), [photo.text for photo in photos]
    first = page.text("name")
    page.press("n")
    page.until(lambda: page.text("name") != first, "the next photo")
    page.press("p")
    page.until(lambda: page.text("name") == first, "the photo before")
    page.until(lambda: page.script("[...document.querySelectorAll('#photo_view img.leaflet-tile')]"
                                   ".filter((i) => i.complete && i.naturalWidth > 0).length > 0"),
               "tiles of the scan")
    page.picture(pictures, "photo")
    page.press("?")
    page.until(lambda: page.script("document.getElementById('help_dialog').open"), "help")
    page.press(page.keys.ESCAPE)
    page.until(lambda: not page.script("document.getElementById('help_dialog').open"), "no help")


def measures_a_mark_by_mouse(page, said):
    photo = page.text("name")
    page.press("m")
    mark = page.at("mark").get_attribute("value")
    assert mark
    page.click_stage("photo_view", 30, 20)
    page.said(f"Saved: mark {mark} of photo {photo}")
    assert f"{photo},{mark}," in (said / "marks.csv").read_text(encoding="utf-8")
    page.press("u")
    page.said(f"Taken back: mark {mark} of photo {photo}")
    assert not (said / "marks.csv").exists()


def measure_by_keys(page, mark, pixel):
    """Moved under the cross."""
    while page.at("mark").get_attribute("value") != mark or not page.script("review.mode"):
        page.press("m")
    page.browser.execute_script(
        "photoView.map.setView(photoView.placeOf(arguments[0]), 0, {animate: false})", list(pixel))
    page.press(page.keys.ARROW_RIGHT, page.keys.ARROW_LEFT, page.keys.ENTER)
    page.said(f"Saved: mark {mark} of photo {page.text('name')}")


def measures_a_mark_by_keys(page, said):
    """At the very pixel where it was found."""
    photo = page.text("name")
    mark, pixel = page.script("[review.photo.interior.marks[0].id, "
                              "review.photo.interior.marks[0].pixel]")
    measure_by_keys(page, mark, pixel)
    line = [row for row in (said / "marks.csv").read_text(encoding="utf-8").splitlines()
            if row.startswith(f"{photo},{mark},")][0].split(",")
    assert abs(float(line[2]) - pixel[0]) < 2 and abs(float(line[3]) - pixel[1]) < 2, (line, pixel)
    page.until(lambda: page.text("hint").startswith(f"Mark {mark} measured "), "the mark, measured")
    assert float(page.text("hint").split()[3]) < 2, page.text("hint")


def measures_a_ground_point(page, said, pictures):
    """In the photo by a click, on the orthophoto by a click; its height is the DEM's."""
    photo = page.text("name")
    page.press("g")
    page.click_stage("photo_view")
    page.until(lambda: page.at("point_form").is_displayed(), "the point's form")
    page.press(page.keys.ESCAPE, "t")  # leaves the field; the map
    page.until(lambda: page.script("review.showsMap"), "the map")
    page.until(lambda: page.script("[...document.querySelectorAll('#map_view img.leaflet-tile')]"
                                   ".filter((i) => i.complete && i.naturalWidth).length > 0"),
               "the orthophoto")
    page.picture(pictures, "map")
    page.click_stage("map_view", 5, 5)
    page.until(lambda: page.at("z").get_attribute("value") != "", "a height")
    page.type("point", "corner <b>of</b> a field")
    page.at("save_point").click()
    page.said(f"Saved: point corner <b>of</b> a field of photo {photo}")
    points = (said / "points.csv").read_text(encoding="utf-8")
    assert "corner <b>of</b> a field" in points and ",control,tester," in points, points
    assert f"{photo},corner" in (said / "image_points.csv").read_text(encoding="utf-8")
    assert not page.browser.find_elements("css selector", "#said b, .leaflet-tooltip b")
    page.press("t", "u")
    page.said(f"Taken back: point corner <b>of</b> a field of photo {photo}")


def orients_again(page, said):
    """Rejected and done again it fails; taken back and done again it is what it was."""
    photo, before = page.text("name"), page.text("status")
    page.type("why", "cloud, <script>alert(1)</script>")
    page.press(page.keys.ESCAPE, "r")
    page.said(f"Saved: reject of photo {photo}")
    page.until(lambda: page.at("pending").is_displayed(), "pending")
    page.press("d")
    page.said("Oriented again.")
    assert page.text("status") == "failed" and "cloud, <script>" in page.text("reasons")
    assert not page.at("pending").is_displayed()
    page.browser.find_element("css selector", "#said li:last-child button").click()  # Withdraw
    page.said(f"Saved: withdrawal of reject of photo {photo}")
    page.press("d")
    page.said("Oriented again.")
    assert page.text("status") == before, page.text("reasons")


def places_a_photo(page, said, block, pictures):
    """Under the cross by keys, then by its handle; oriented again it starts from there."""
    photo = page.text("name")
    own = "review.map.photos.find((p) => p.name === review.photo.name)"
    page.press("o")
    page.until(lambda: page.script("review.showsMap"), "the map")
    x, y = page.script(own + ".centre.slice(0, 2)")
    page.browser.execute_script(
        "mapView.map.setView(mapView.placeOf(arguments[0]), -1, {animate: false})", [x + 30, y - 20])
    page.press(page.keys.ENTER)
    page.until(lambda: page.text("message").startswith("Saved: position "), "its position")
    first = page.script(own + ".said_at")
    assert abs(first[0] - x - 30) < 5 and abs(first[1] - y + 20) < 5, (first, x, y)
    handle = page.browser.find_element("css selector", ".handle")
    page.picture(pictures, "placed")
    drag = page.actions(page.browser).click_and_hold(handle).pause(0.1)
    drag.move_by_offset(6, 0).pause(0.1).move_by_offset(8, 2).pause(0.1).release().perform()
    page.until(lambda: page.script(own + ".said_at[0]") > first[0] + 1, "the place it was dragged to")
    row = [line for line in (said / "decisions.csv").read_text(encoding="utf-8").splitlines()
           if line.startswith(f"{photo},position,")]
    assert len(row) == 1, row
    page.press("t", "d")
    page.said("Oriented again.")
    result = json.loads((block / f"out/{photo}.exterior.json").read_text(encoding="utf-8"))
    moved = page.script(own + ".said_at")
    assert abs(result["approximation"]["x"] - moved[0]) < 0.1, result["approximation"]
    assert result["approximation"]["sigma"][0] == float(row[0].split(",")[2].split()[2])
    page.press("u")
    page.until(lambda: page.text("message").startswith("Taken back: position "), "taken back")
    assert page.script(own + ".said_at") == first


def done_again(server):
    """Waits for the end of a run that is asked for; what it says of its end."""
    status, _, body = server.ask("POST", "api/again", "{}")
    assert status == 200, body
    until = time.monotonic() + 120
    while time.monotonic() < until:
        progress = server.get("api/progress")
        if not progress["running"]:
            return progress["error"]
        time.sleep(0.1)
    raise AssertionError("the run does not end")


def single_photos_are_oriented_again(orient, block):
    """A folder of orient interior and orient exterior: both stages, as its run.json says."""
    out, said = block / "single", block / "of_single"
    scans = sorted((block / "scans").glob("*.tif"))
    camera = ["--camera", block / "camera.toml", "--out", out]
    # Options that are not the defaults: a run that forgets them does other photos again, too.
    interior = ["--roll", "differing", "--scanner", "photogrammetric", "--pixel-size-um", 100,
                "--orientation", "r0"]
    exterior = ["--approximations", block / "approx.csv", "--dem", block / "dem.tif", "--patchdb",
                block / "patches.gpkg", "--interior", out, "--position-sigma-m", 12]
    for words in (["interior", *scans, *camera, *interior], ["exterior", *scans, *camera, *exterior]):
        subprocess.run([orient, *map(str, words)], check=True, capture_output=True)

    def results():
        return {path.name: path.read_bytes() for path in sorted(out.iterdir())
                if path.suffix in (".json", ".csv") and path.name != "run.json"}

    def changed():
        now = results()
        return {name for name in now.keys() | before.keys() if now.get(name) != before.get(name)}

    photo, before = scans[0].stem, results()
    with running(orient, out, "--measurements", said) as server:
        assert done_again(server) == "" and not changed(), "nothing was said"
        assert server.say({"decisions": [{"photo": photo, "decision": "reject", "value": "",
                                          "reason": "cloud"}]}) == 200
        assert done_again(server) == ""
        result = json.loads((out / f"{photo}.exterior.json").read_text(encoding="utf-8"))
        assert result["status"] == "failed"
        of_photo = {f"{photo}.{stage}.json" for stage in ("interior", "exterior")}
        tables = {"orientation.csv", "interior.csv", "marks.csv"}
        assert of_photo <= changed() <= of_photo | tables, changed()
        assert photo not in (out / "orientation.csv").read_text(encoding="utf-8")
        status, _, body = server.ask("POST", "api/undo", json.dumps(
            {"version": server.get("api/list")["version"]}))
        assert status == 200, body
        mark = json.loads(before[f"{photo}.interior.json"])["marks"][0]
        click = {"photo": photo, "mark": mark["id"], "pixel": mark["pixel"], "sigma": 1,
                 "exact": False}
        assert server.say({"marks": [{**click, "pixel": [-5, 1e8]}]}) == 422
        assert server.say({"marks": [click]}) == 200
        assert done_again(server) == ""
        assert f"{photo}.interior.json" in changed() <= of_photo | tables, changed()
        result = json.loads((out / f"{photo}.exterior.json").read_text(encoding="utf-8"))
        assert result["status"] == "ok"
    what_cannot_be_repeated_is_said(orient, block, out, scans)


def what_cannot_be_repeated_is_said(orient, block, out, scans):
    """A folder whose making is not known, or from elsewhere, a block's: nothing is changed."""
    def refused(folder, *more):
        files = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
        with running(orient, folder, *scans, "--measurements", block / "of_other", *more) as server:
            status, _, body = server.ask("POST", "api/again", "{}")
            assert status == 422, body
        assert files == {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
        return json.loads(body)["error"]

    record = json.loads((out / "run.json").read_text(encoding="utf-8"))
    record["exterior"]["directory"] = "/elsewhere"
    (out / "run.json").write_text(json.dumps(record), encoding="utf-8")
    assert "start orient review there" in refused(out)
    del record["exterior"]["arguments"]
    (out / "run.json").write_text(json.dumps(record), encoding="utf-8")
    assert "earlier program" in refused(out)
    (out / "run.json").unlink()
    assert "no run.json" in refused(out)
    assert "--block" in refused(block / "out", "--camera", block / "camera.toml")


def filters(page):
    all_photos = len(page.browser.find_elements("css selector", "#photos button"))
    page.browser.execute_script("const s = document.getElementById('state'); s.value = 'failed';"
                                "s.dispatchEvent(new Event('change'))")
    failed = len(page.browser.find_elements("css selector", "#photos button"))
    assert failed == page.script("review.list.photos.filter((p) => p.status === 'failed').length")
    assert failed < all_photos
    page.browser.execute_script("const s = document.getElementById('state'); s.value = '';"
                                "s.dispatchEvent(new Event('change'))")


def a_second_window_is_told(page, server, said):
    photo = page.text("name")
    assert server.say({"decisions": [{"photo": photo, "decision": "polarity", "value": "negative",
                                      "reason": "other window"}]}) == 200
    page.press("r")
    page.until(lambda: "another window" in page.text("message"), "a word about the other window")
    page.until(lambda: "other window" in page.text("said"), "what the other window said")
    text = (said / "decisions.csv").read_text(encoding="utf-8")
    assert "reject" not in text and "negative" in text


def narrow_screens_have_all(page, pictures):
    page.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": False})
    page.browser.refresh()
    page.until(lambda: page.text("name") != "No photo", "a photo is shown")
    time.sleep(0.5)
    assert page.script("document.documentElement.scrollWidth") <= 400
    page.picture(pictures, "narrow")
    page.browser.execute_script("document.querySelector('aside').scrollIntoView()")
    page.picture(pictures, "narrow_panel")
    page.browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def real_film():
    """The folder of real frames; None where it is absent."""
    root = pathlib.Path(__file__).resolve().parents[3]
    film = pathlib.Path(os.environ.get("ORIENT_SHARED_DATA", root / "../shared/data")) / "film"
    if film.is_dir():
        return film
    print("not tried on real frames: real data absent (ORIENT_SHARED_DATA): film")
    return None


def click_mark(page, mark, pixel):
    """Named and clicked to a whole pixel, as a person does who knows no camera file."""
    page.type("mark", mark)
    page.at("measure").click()
    page.browser.execute_script(
        "photoView.map.setView(photoView.placeOf(arguments[0]), 2, {animate: false})", list(pixel))
    page.press(page.keys.ENTER)
    page.said(f"Saved: mark {mark} of photo {page.text('name')}")


def a_camera_from_clicks(page, orient, folder, pictures):
    """A camera that no library has, from one scan: it reads the roll's other frame alone."""
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
    """A curled print of a real film: three marks by eye (of four, one cannot be seen)."""
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
            measure_by_keys(page, mark, pixel)
        page.press("d")
        page.said("Oriented again.")
        assert page.text("status") == "weak", page.text("reasons")
        page.picture(pictures, "film")
        assert not page.errors() and not page.foreign_requests()


def markup_in_names_does_nothing(page, orient, folder, pictures):
    names = make_folder(folder)
    with running(orient, folder / "out", *(folder / "scans").iterdir(), "--measurements",
                 folder / "said") as server:
        page.open(server.address)
        looks_and_moves(page, names, None)
        listed = page.text("photos")
        assert all(name in listed for name in names), listed
        assert not page.browser.find_elements("css selector", "img[src='x'], img[onerror]")
        filters(page)
        page.picture(pictures, "markup")
        assert not page.errors() and not page.foreign_requests()


def start_browser():
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    options = webdriver.ChromeOptions()
    for flag in [*FLAGS, "--window-size=1400,900"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))


def main(orient, pictures=None):
    try:
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.keys import Keys
    except ImportError:
        if sys.executable != DEBIAN_PYTHON and pathlib.Path(DEBIAN_PYTHON).exists():
            os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
        print("skipped: python3-selenium is not installed")
        return SKIPPED
    if not shutil.which("chromium") or not shutil.which("chromedriver"):
        print("skipped: chromium or chromium-driver is not installed")
        return SKIPPED
    pictures = pathlib.Path(pictures) if pictures else None
    browser = start_browser()
    try:
        page = Page(browser, Keys, ActionChains)
        with tempfile.TemporaryDirectory() as name:
            block = make_block(orient, pathlib.Path(name))
            said = block / "said"
            with running(orient, block / "out", "--block", block / "block.toml", "--ortho",
                         block / "old/ortho.tif", "--by", "tester") as server:
                page.open(server.address)
                looks_and_moves(page, ["new_1_1", "new_1_2", "new_1_3"], pictures)
                measures_a_mark_by_mouse(page, said)
                measures_a_mark_by_keys(page, said)
                measures_a_ground_point(page, said, pictures)
                orients_again(page, said)
                places_a_photo(page, said, block, pictures)
                page.picture(pictures, "done_again")
                assert not page.errors(), page.errors()
                a_second_window_is_told(page, server, said)
                narrow_screens_have_all(page, pictures)
                assert not page.foreign_requests(), page.foreign_requests()
            single_photos_are_oriented_again(orient, block)
        with tempfile.TemporaryDirectory() as name:
            browser.get_log("browser")  # the refusal above is told there, too
            markup_in_names_does_nothing(page, orient, pathlib.Path(name), pictures)
            a_failed_frame_becomes_weak(page, orient, pathlib.Path(name), pictures)
            a_camera_from_clicks(page, orient, pathlib.Path(name), pictures)
    finally:
        browser.quit()
    print("the page does what it says")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
