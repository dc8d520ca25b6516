"""A web server with range requests, like an object store, that can be slow and unreliable.

    with ObjectStore(folder, busy=0.05, cut=0.01, delay_s=0.2) as store: store.url, store.bytes_sent

`busy` is the share of requests answered with 503 (or `code`), `cut` the share of answers that break
off half-way; `seed` and the number of the request determine which. As a script, it serves FOLDER
until interrupted:

    object_store.py FOLDER [BUSY [CUT [DELAY_S]]]
"""

import http.server
import pathlib
import random
import re
import sys
import threading
import time
import urllib.parse


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_HEAD(self):
        self.answer(body=False)

    def do_GET(self):
        self.answer(body=True)

    def answer(self, body):
        store = self.server.store
        fault = store.next_fault()
        time.sleep(store.delay_s)
        name = urllib.parse.unquote(urllib.parse.urlsplit(self.path).path).lstrip("/")
        path = (store.folder / name).resolve()
        if fault == "busy":
            return self.end(store.code)
        if not path.is_relative_to(store.folder) or not path.exists():
            return self.end(404)
        if path.is_dir():
            return self.list(path)
        size = path.stat().st_size
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        first = int(asked[1]) if asked else 0
        last = min(int(asked[2]) if asked and asked[2] else size - 1, size - 1)
        if first >= size:
            return self.end(416)
        self.send_response(206 if asked else 200)
        if asked:
            self.send_header("Content-Range", f"bytes {first}-{last}/{size}")
        self.send_header("Accept-Ranges", "bytes")
        self.send_header("Content-Length", str(last - first + 1))
        self.end_headers()
        if not body:
            return None
        with open(path, "rb") as file:
            file.seek(first)
            contents = file.read(last - first + 1)
        if fault == "cut":
            contents = contents[:len(contents) // 2]
            store.cuts += 1
            self.close_connection = True
        store.sent(len(contents))
        try:
            self.wfile.write(contents)
        except ConnectionError:
            pass
        return None

    def list(self, folder):
        links = "".join(f'<a href="{urllib.parse.quote(entry.name)}">{entry.name}</a>\n'
                        for entry in sorted(folder.iterdir()))
        name = f"/{folder.relative_to(self.server.store.folder)}"
        text = (f"<html><head><title>Index of {name}</title></head><body>\n"
                f"{links}</body></html>").encode()  # as nginx and Apache do, which GDAL reads
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)

    def end(self, code):
        self.send_response(code)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


class ObjectStore:
    def __init__(self, folder, busy=0.0, cut=0.0, delay_s=0.0, seed=1, handler=Handler):
        self.folder = pathlib.Path(folder).resolve()
        self.busy, self.cut, self.delay_s, self.seed = busy, cut, delay_s, seed
        self.code = 503
        self.requests = self.bytes_sent = self.faults = self.cuts = 0
        self.lock = threading.Lock()
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self._server.store = self
        self.url = f"http://127.0.0.1:{self._server.server_port}"

    def __enter__(self):
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self._server.shutdown()
        self._server.server_close()

    def next_fault(self):
        with self.lock:
            self.requests += 1
            draw = random.Random(f"{self.seed} {self.requests}").random()
            fault = "busy" if draw < self.busy else "cut" if draw < self.busy + self.cut else None
            self.faults += fault is not None
            return fault

    def sent(self, count):
        with self.lock:
            self.bytes_sent += count


def main(folder, busy="0", cut="0", delay_s="0"):
    with ObjectStore(folder, float(busy), float(cut), float(delay_s)) as store:
        print(store.url, flush=True)
        threading.Event().wait()


if __name__ == "__main__":
    main(*sys.argv[1:])
