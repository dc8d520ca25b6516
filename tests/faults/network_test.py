#!/usr/bin/env python3
"""CTest `faults_network`: a scan that cannot be fetched does not become a photo's result.

    network_test.py ORIENT

A server in this process answers some requests for a scan and then fails, in one of two ways.
`orient interior` must end with exit code 4 and store nothing; when the server works again, the
result must be the same as from the local file. A scan that does not exist fails alone.
"""

import concurrent.futures
import http.server
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading

MACHINE, SOME_FAILED = 4, 3


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def do_HEAD(self):
        self.answer(False)

    def do_GET(self):
        self.answer(True)

    def answer(self, with_body):
        server = self.server
        server.left -= 1
        if server.left < 0 and server.drops:
            self.close_connection = True
            return self.connection.close()
        path = server.folder / self.path.lstrip("/")
        if server.left < 0 or not path.is_file():
            return self.reply(503 if server.left < 0 else 404, b"", {}, True)
        data = path.read_bytes()
        asked = re.match(r"bytes=(\d+)-(\d+)", self.headers.get("Range", ""))
        if not asked:
            return self.reply(200, data, {}, with_body)
        first, last = int(asked[1]), min(int(asked[2]), len(data) - 1)
        head = {"Content-Range": f"bytes {first}-{last}/{len(data)}"}
        return self.reply(206, data[first:last + 1], head, with_body)

    def reply(self, code, body, head, with_body):
        self.send_response(code)
        for name, value in {**head, "Accept-Ranges": "bytes", "Content-Length": str(len(body))}.items():
            self.send_header(name, value)
        self.end_headers()
        if with_body:
            self.wfile.write(body)


def interior(orient, folder, scan, out):
    return subprocess.run([orient, "interior", scan, "--camera", folder / "camera.toml", "--out", out],
                          capture_output=True, text=True, check=False, timeout=120,
                          env={**os.environ, "GDAL_HTTP_MAX_RETRY": "0"})  # orient still retries


def serving(folder, left, drops):
    """A server that fails after `left` answers: it hangs up if `drops`, else answers with 503."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.folder, server.left, server.drops = folder, left, drops
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server, f"/vsicurl/http://127.0.0.1:{server.server_port}"


def a_fault_is_no_result(orient, folder, left, drops):
    server, here = serving(folder / "scans", left, drops)
    out = folder / f"out{left}{drops}"
    done = interior(orient, folder, f"{here}/new_1_1.tif", out)
    assert done.returncode == MACHINE and here in done.stderr, done.stdout + done.stderr
    assert not list(out.glob("*.json")), "a fault became a result"
    server.left = 10**6
    results = []
    for place in (here, folder / "scans"):
        done = interior(orient, folder, f"{place}/new_1_1.tif", out)
        assert done.returncode == 0, done.stdout + done.stderr
        results.append((out / "new_1_1.interior.json").read_bytes())
        for path in out.iterdir():
            path.unlink()
    assert results[0] == results[1], "another result over the network"
    done = interior(orient, folder, f"{here}/absent.tif", out)
    assert done.returncode == SOME_FAILED, done.stdout + done.stderr
    server.shutdown()


def main(orient):
    with tempfile.TemporaryDirectory() as temporary:
        subprocess.run([orient, "simulate", "--out", temporary + "/made", "--photos", "1", "--gsd-m",
                        "1.5", "--pixel-size-um", "150", "--bare"], check=True, capture_output=True)
        folder = pathlib.Path(temporary) / "made"
        faults = [(0, False), (2, False), (5, True), (1, True)]
        # In parallel: nearly all of the time is spent waiting before a request is repeated.
        with concurrent.futures.ThreadPoolExecutor(len(faults)) as pool:
            list(pool.map(lambda fault: a_fault_is_no_result(orient, folder, *fault), faults))


if __name__ == "__main__":
    main(sys.argv[1])
