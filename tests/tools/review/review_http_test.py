#!/usr/bin/env python3
"""CTest `review_http`: `orient review` answers only its own page, and loses no entry.

    review_http_test.py ORIENT [--all]     --all: more requests and kills, scans oriented again

The program runs as started by a user; Python's standard library speaks HTTP to it.
"""

import concurrent.futures
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

from review_server import MARKUP, make_folder, running


def mark(photo, number, col):
    return {"about": f"mark {number}",
            "marks": [{"photo": photo, "mark": str(number), "pixel": [col, 50.5], "sigma": 1,
                       "exact": False}]}


def files_of(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.csv")}


def strangers_are_refused(server, said):
    before = files_of(said)
    word = json.dumps({"version": server.get("api/list")["version"], **mark("a", 1, 5)})
    own = f"127.0.0.1:{server.port}"
    refusals = [
        (403, ("GET", "api/list"), {"token": "0" * 32}),
        (403, ("POST", "api/say", word), {"token": "0" * 32}),
        (403, ("GET", "api/list"), {"token": ""}),
        (403, ("POST", "api/say", word), {"headers": {"Origin": "https://evil.example"}}),
        (403, ("POST", "api/say", word), {"headers": {"Origin": "null"}}),
        (403, ("GET", "api/list"), {"headers": {"Sec-Fetch-Site": "cross-site"}}),
        (421, ("GET", "api/list"), {"headers": {"Host": f"evil.example:{server.port}"}}),
        (415, ("POST", "api/say", word), {"headers": {"Content-Type": "text/plain"}}),
        (415, ("POST", "api/say", word), {"headers": {"Content-Encoding": "gzip"}}),
        (405, ("PUT", "api/say", word), {"headers": {"Content-Type": "application/json"}}),
        (405, ("DELETE", "api/say"), {}),
        (400, ("GET", "../../../../etc/passwd"), {}),
        (400, ("GET", "%2e%2e/%2e%2e/etc/passwd"), {}),
        (400, ("GET", "tile/..%2f..%2fetc%2fpasswd/0/0/0"), {}),
        (404, ("GET", "etc/passwd"), {}),
        (404, ("GET", "tile/%2fetc%2fpasswd/0/0/0"), {}),
        (404, ("GET", "api/photo/nobody"), {}),
    ]
    for status, asked, how in refusals:
        got, _, body = server.ask(*asked, **how)
        assert got == status, (status, asked, how, got, body)
        assert b"root:" not in body, asked
    assert files_of(said) == before
    status, headers, _ = server.ask("GET", "", headers={"Host": own})
    assert status == 200 and "default-src 'none'" in headers["Content-Security-Policy"]
    assert headers["Referrer-Policy"] == "no-referrer"


def huge_bodies_are_refused(server, said):
    """By their stated length before they are read, and if no length is stated."""
    before = files_of(said)
    for head in (b"Content-Length: 100000000", b"Transfer-Encoding: chunked"):
        with socket.create_connection((server.host, server.port), timeout=30) as connection:
            connection.sendall(b"POST /%s/api/say HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n"
                               b"Content-Type: application/json\r\n%s\r\n\r\n" %
                               (server.token.encode(), server.port, head))
            answer = connection.recv(64)
            assert answer.split()[1] in (b"413", b"411"), answer
    assert files_of(said) == before
    assert resident_mb(server) < 300


def resident_mb(server):
    status = pathlib.Path(f"/proc/{server.process.pid}/status").read_text(encoding="ascii")
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


def many_requests_are_answered(server, names, number):
    paths = ["api/list", "", "leaflet.js", f"tile/{names[0]}/0/0/0", "api/photo/z", "api/map"]
    with concurrent.futures.ThreadPoolExecutor(100) as pool:
        answers = list(pool.map(lambda i: server.ask("GET", paths[i % len(paths)])[0],
                                range(number)))
    assert set(answers) == {200}, set(answers)
    # Connections that send nothing do not keep others waiting for long.
    silent = [socket.create_connection((server.host, server.port)) for _ in range(30)]
    assert server.get("api/list")["photos"]
    for connection in silent:
        connection.close()


def slow_connections_do_not_stop_it(server, number):
    """Request headers that arrive byte by byte and never end."""
    slow = [socket.create_connection((server.host, server.port)) for _ in range(number)]
    for sent in b"GET /ab":
        for connection in slow:
            connection.sendall(bytes([sent]))
        begun = time.monotonic()
        assert server.get("api/list")["photos"]
        assert time.monotonic() - begun < 3
        time.sleep(0.2)
    for connection in slow:
        connection.close()


def the_page_is_opened(orient, folder, words):
    """By the desktop's own program, which is passed the address."""
    opener = folder / "bin/xdg-open"
    opener.parent.mkdir()
    opener.write_text(f'#!/bin/sh\necho "$1" > "{folder}/opened"\n', encoding="utf-8")
    opener.chmod(0o755)
    path = os.environ["PATH"]
    os.environ["PATH"] = f"{opener.parent}:{path}"
    try:
        with running(orient, *words, "--open") as server:
            until = time.monotonic() + 20
            while not (folder / "opened").exists() or not (folder / "opened").read_text():
                assert time.monotonic() < until, "nothing was opened"
                time.sleep(0.05)
            assert (folder / "opened").read_text(encoding="utf-8").strip() == server.address
    finally:
        os.environ["PATH"] = path


def names_are_text(server, names):
    """Markup in a name remains a string of the JSON; the page itself contains no names."""
    listed = [photo["name"] for photo in server.get("api/list")["photos"]]
    assert sorted(listed) == sorted(names), listed
    status, headers, body = server.ask("GET", "")
    assert status == 200 and headers["Content-Type"].startswith("text/html")
    assert b"onerror" not in body
    status, headers, _ = server.ask("GET", "api/list")
    assert headers["Content-Type"] == "application/json"
    assert headers["X-Content-Type-Options"] == "nosniff"


def two_windows_do_not_lose_words(server, said):
    version = server.get("api/list")["version"]
    first, second = ({"version": version, **mark("a", 2, col)} for col in (60.5, 70.5))
    assert server.say(first) == 200
    assert server.say(second) == 409
    assert "60.5" in (said / "marks.csv").read_text(encoding="utf-8")


def killed_programs_lose_no_word(orient, folder, words, kills):
    for number in range(kills):
        with running(orient, *words) as server:
            assert server.say(mark("z", f"k{number}", number)) == 200
            server.process.kill()
        text = (folder / "said/marks.csv").read_text(encoding="utf-8")
        assert all(f"z,k{i},{i}," in text for i in range(number + 1)), text
    assert not list((folder / "said").glob("*.part"))
    with running(orient, *words) as server:  # and everything can be undone
        for i in reversed(range(kills)):
            listed = server.get("api/list")
            assert listed["undo"] == f"mark k{i}", listed["undo"]
            version = json.dumps({"version": listed["version"]})
            assert server.ask("POST", "api/undo", version)[0] == 200
    assert "z,k" not in (folder / "said/marks.csv").read_text(encoding="utf-8")


def interiors_are_measured_again(orient, folder):
    """A rejected scan of `orient interior` fails when it is oriented again, and only then."""
    def status():
        return {photo["name"]: photo["status"] for photo in server.get("api/list")["photos"]}

    def again():
        code, _, body = server.ask("POST", "api/again", "{}")
        assert code == 200, body
        while (progress := server.get("api/progress"))["running"]:
            time.sleep(0.05)
        return progress["error"]

    world = folder / "world"
    scan = ["--pixel-size-um", 150, "--polarity", "positive", "--orientation", "r0"]
    camera = ["--camera", world / "camera.toml"]
    done = {"check": True, "capture_output": True}
    subprocess.run([orient, "simulate", "--out", world, "--photos", "2", "--gsd-m", "3",
                    "--pixel-size-um", "150", "--bare"], **done)
    scans = sorted((world / "scans").glob("*.tif"))
    subprocess.run([orient, "interior", *scans, *camera, "--out", folder / "films",
                    *map(str, scan)], **done)
    words = [folder / "films", "--measurements", folder / "said_of_films"]
    with running(orient, *words) as server:
        before = status()
        assert set(before.values()) == {"ok"}, before
        photo = sorted(before)[0]
        assert server.say({"decisions": [{"photo": photo, "decision": "reject", "value": "",
                                          "reason": "cloud"}]}) == 200
        assert status() == before
        assert again() == ""
        assert status() == {**before, photo: "failed"}
        version = json.dumps({"version": server.get("api/list")["version"]})
        assert server.ask("POST", "api/undo", version)[0] == 200
        assert again() == "" and status() == before
    text = (world / "camera.toml").read_text(encoding="utf-8")
    changed = text.replace("principal_distance_mm = ", "principal_distance_mm = 1")
    (world / "camera.toml").write_text(changed, encoding="utf-8")
    with running(orient, *words) as server:  # with a different camera file than the run
        assert "made from other inputs" in again()
        assert status() == before


def wrong_starts_are_refused(orient, folder, words, server):
    def said_on_stderr(*more):
        done = subprocess.run([orient, "review", *map(str, more)], capture_output=True, text=True,
                              timeout=30, check=False)
        return done.returncode, done.stderr

    assert said_on_stderr(*words)[0] == 2  # another review uses the folder
    code, text = said_on_stderr(folder / "out", "--measurements", folder / "other")
    assert code == 2 and "another orient" in text, (code, text)  # and OUT, whatever it writes to
    shutil.copytree(folder / "out", folder / "copy", ignore=shutil.ignore_patterns("*.lock"))
    code, text = said_on_stderr(folder / "copy", "--measurements", folder / "other", "--port",
                                server.port)
    assert code == 1 and "port" in text, (code, text)
    code, text = said_on_stderr(folder / "out")
    assert code == 1 and "--measurements" in text
    code, text = said_on_stderr(folder / "out", "--measurements", folder / "out/")
    assert code == 1 and "marks.csv" in text
    assert said_on_stderr(folder / "scans", "--measurements", folder / "other")[0] == 2


def main(orient, more=None):
    requests, kills = (1000, 40) if more else (150, 4)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        names = make_folder(folder)
        said = folder / "said"
        words = [folder / "out", *sorted((folder / "scans").iterdir()), "--measurements", said,
                 "--by", MARKUP]
        with running(orient, *words) as server:
            assert server.say(mark("a", 1, 50.5)) == 200
            strangers_are_refused(server, said)
            huge_bodies_are_refused(server, said)
            many_requests_are_answered(server, names, requests)
            slow_connections_do_not_stop_it(server, 200 if more else 60)
            names_are_text(server, names)
            two_windows_do_not_lose_words(server, said)
            wrong_starts_are_refused(orient, folder, words, server)
        killed_programs_lose_no_word(orient, folder, words, kills)
        the_page_is_opened(orient, folder, words)
        if more:
            interiors_are_measured_again(orient, folder)
    print("strangers are refused, words are kept")


if __name__ == "__main__":
    main(*sys.argv[1:])
