#!/usr/bin/env python3
"""CTest `review_page` (slow): the page of `orient review` in a real browser, by mouse and by keys.

    review_page_test.py ORIENT [PICTURES]    PICTURES: folder for screenshots

Needs Debian's chromium, chromium-driver and python3-selenium, and is skipped (exit code 77) without
them. A simulated block of three photos is oriented; on the page, a mark is measured, a ground point
is measured in photo and map, a photo is placed on the map, and decisions are made, undone,
withdrawn, and carried out.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from browser_page import Page, start_browser
from review_film import a_camera_from_clicks, a_failed_frame_becomes_weak
from review_recorded import single_photos_are_oriented_again
from review_server import make_folder, running

SKIPPED = 77
DEBIAN_PYTHON = "/usr/bin/python3"  # has the package selenium


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


def measures_a_mark_by_keys(page, said):
    """At the pixel where it was found automatically."""
    photo = page.text("name")
    mark, pixel = page.script("[review.photo.interior.marks[0].id, "
                              "review.photo.interior.marks[0].pixel]")
    page.measure_by_keys(mark, pixel)
    line = [row for row in (said / "marks.csv").read_text(encoding="utf-8").splitlines()
            if row.startswith(f"{photo},{mark},")][0].split(",")
    assert abs(float(line[2]) - pixel[0]) < 2 and abs(float(line[3]) - pixel[1]) < 2, (line, pixel)
    page.until(lambda: page.text("hint").startswith(f"Mark {mark} measured "), "the mark, measured")
    assert float(page.text("hint").split()[3]) < 2, page.text("hint")


def measures_a_ground_point(page, said, pictures):
    """By a click in the photo and one on the orthophoto; its height is taken from the DEM."""
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


def measures_a_ground_point_by_keys(page, said):
    """Under the cross in the photo, then on the map; its coordinates are withdrawn separately."""
    photo = page.text("name")
    page.press("g", page.keys.ENTER)
    page.until(lambda: page.at("point_form").is_displayed(), "the point's form")
    page.press(page.keys.ESCAPE, "t", page.keys.ARROW_RIGHT, page.keys.ENTER)
    page.until(lambda: page.at("z").get_attribute("value") != "", "a height")
    page.until(lambda: page.script("document.activeElement.id") == "point", "the name's field")
    name = page.at("point").get_attribute("value")
    page.press(page.keys.ENTER)
    page.said(f"Saved: point {name} of photo {photo}")
    rows = page.browser.find_elements("css selector", "#said li")
    row = [one for one in rows if one.text.startswith(f"coordinates of {name}: ")]
    assert len(row) == 1, [one.text for one in rows]
    row[0].find_element("css selector", "button").click()
    page.said(f"Saved: withdrawal of coordinates of point {name} of photo {photo}")
    assert f"{name}," not in (said / "points.csv").read_text(encoding="utf-8")
    assert f"{photo},{name}," in (said / "image_points.csv").read_text(encoding="utf-8")
    page.press(page.keys.ESCAPE, "t", "u")
    page.said(f"Taken back: withdrawal of coordinates of point {name} of photo {photo}")
    page.press("u")
    page.said(f"Taken back: point {name} of photo {photo}")
    assert not (said / "points.csv").exists()


def decides(page, said):
    """Accepts the photo by a key and describes it in the panel; all of this is then undone."""
    photo, before = page.text("name"), (said / "decisions.csv").read_text(encoding="utf-8")
    page.type("why", "seen")
    page.press(page.keys.ESCAPE, "a")
    page.said(f"Saved: accept of photo {photo}")
    decided = [("orientation", "r0"), ("polarity", "positive"), ("pixel_size", "100"),
               ("camera", "survey 150")]
    for kind, value in decided:
        page.browser.execute_script(
            "const k = document.getElementById('kind'); k.value = arguments[0];"
            "k.dispatchEvent(new Event('change'))", kind)
        page.type("value", value)
        page.at("decide").click()
        page.said(f"Saved: {kind} {value} of photo {photo}")
    text = (said / "decisions.csv").read_text(encoding="utf-8")
    for kind, value in [("accept", ""), *decided]:
        assert f"{photo},{kind},{value}," in text, text
    page.type("value", "sideways")
    page.browser.execute_script("document.getElementById('kind').value = 'orientation'")
    page.at("decide").click()
    page.until(lambda: "sideways" in page.text("message"), "what is wrong with the value")
    told = page.errors()  # the browser reports it, too
    assert len(told) == 1 and "422" in told[0]["message"], told
    assert "sideways" not in (said / "decisions.csv").read_text(encoding="utf-8")
    page.type("value", "")
    page.browser.execute_script("document.activeElement.blur()")
    for kind, value in reversed([("accept", ""), *decided]):
        page.press("u")
        page.said(f"Taken back: {f'{kind} {value}'.strip()} of photo {photo}")
    assert (said / "decisions.csv").read_text(encoding="utf-8") == before


def patches_lie_on_the_map(page):
    """The patches of the photo that is shown."""
    shown = page.script("mapView.patches.getLayers().length")
    assert shown == page.script("review.photo.exterior.patches.length") > 50, shown


def orients_again(page, said):
    """A rejected photo fails when oriented again; once this is withdrawn, it is as before."""
    photo, before = page.text("name"), page.text("status")
    page.type("why", "cloud, <script>alert(1)</script>")
    page.press(page.keys.ESCAPE, "r")
    page.said(f"Saved: reject of photo {photo}")
    page.until(lambda: page.at("pending").is_displayed(), "pending")
    page.press("d")
    page.said("Oriented again.")
    assert page.text("status") == "failed" and "cloud, <script>" in page.text("reasons")
    assert not page.at("pending").is_displayed()
    filters_by_reason(page)
    page.browser.find_element("css selector", "#said li:last-child button").click()  # Withdraw
    page.said(f"Saved: withdrawal of reject of photo {photo}")
    page.press("d")
    page.said("Oriented again.")
    assert page.text("status") == before, page.text("reasons")


def places_a_photo(page, said, block, pictures):
    """Under the cross by keys, then by its handle; orientation then starts from there."""
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


def filters(page):
    all_photos = len(page.browser.find_elements("css selector", "#photos button"))
    page.browser.execute_script("const s = document.getElementById('state'); s.value = 'failed';"
                                "s.dispatchEvent(new Event('change'))")
    failed = len(page.browser.find_elements("css selector", "#photos button"))
    assert failed == page.script("review.list.photos.filter((p) => p.status === 'failed').length")
    assert failed < all_photos
    page.browser.execute_script("const s = document.getElementById('state'); s.value = '';"
                                "s.dispatchEvent(new Event('change'))")


def filters_by_reason(page):
    choose = ("const s = document.getElementById('reason'); s.value = arguments[0];"
              "s.dispatchEvent(new Event('change'))")
    codes = page.script("[...document.getElementById('reason').options].map((o) => o.value)")
    assert len(codes) > 1, codes
    for code in codes[1:]:
        page.browser.execute_script(choose, code)
        shown = len(page.browser.find_elements("css selector", "#photos button"))
        wanted = page.browser.execute_script(
            "return review.list.photos.filter((p) => p.codes.includes(arguments[0])).length", code)
        assert shown == wanted > 0, (code, shown, wanted)
    page.browser.execute_script(choose, "")


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
                measures_a_ground_point_by_keys(page, said)
                decides(page, said)
                patches_lie_on_the_map(page)
                orients_again(page, said)
                places_a_photo(page, said, block, pictures)
                page.picture(pictures, "done_again")
                told = page.errors()
                assert not told, told
                a_second_window_is_told(page, server, said)
                narrow_screens_have_all(page, pictures)
                assert not page.foreign_requests(), page.foreign_requests()
            single_photos_are_oriented_again(orient, block)
        with tempfile.TemporaryDirectory() as name:
            browser.get_log("browser")  # the refusal above is reported there, too
            markup_in_names_does_nothing(page, orient, pathlib.Path(name), pictures)
            a_failed_frame_becomes_weak(page, orient, pathlib.Path(name), pictures)
            a_camera_from_clicks(page, orient, pathlib.Path(name), pictures)
    finally:
        browser.quit()
    print("the page does what it says")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
