"""Folders of `orient interior` and `orient exterior`, oriented again as their run.json states."""

import json
import subprocess
import time

from review_server import running


def done_again(server):
    """Starts a run and waits for its end; returns its error message, empty on success."""
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
    """A folder of orient interior and orient exterior: both stages, as its run.json states."""
    out, said = block / "single", block / "of_single"
    scans = sorted((block / "scans").glob("*.tif"))
    camera = ["--camera", block / "camera.toml", "--out", out]
    # Options that are not the defaults: a run that ignores them orients other photos again, too.
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
    """A folder of unknown origin, one from elsewhere, or a block's: nothing is changed."""
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
