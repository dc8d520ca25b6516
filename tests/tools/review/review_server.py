"""Starts `orient review` for tests, on a small output folder with malicious photo names."""

import contextlib
import http.client
import json
import subprocess
import urllib.parse

MARKUP = "<img src=x onerror=alert(1)>&\"'"
SIDE = 400  # of a scan, px


def interior_result(photo, status):
    ok = status != "failed"
    return {
        "photo": photo, "status": status,
        "scan": {"width": SIDE, "height": SIDE, "pixel_size_um": 100.0, "polarity": "positive",
                 "orientation": "r0"},
        "photo_from_pixel": [[0.1, 0, -20], [0, -0.1, 20]] if ok else None,
        "sigma0_um": 4.0 if ok else None, "margin": 9.0 if ok else None,
        "marks": [{"id": f"{i + 1}", "state": "used" if ok else "missing",
                   "pixel": [50 + 300 * (i % 2), 50 + 300 * (i // 2)] if ok else None,
                   "sigma_px": [0.1, 0.1] if ok else None,
                   "residual_um": [3.0, -2.0] if ok else None, "score": 0.9 if ok else None}
                  for i in range(4)],
        "messages": [] if status == "ok" else [f"{MARKUP} is why"]}


def make_folder(folder):
    """Photos a (ok), the one with markup in its name (weak), and z (failed); scans of all."""
    (folder / "out").mkdir()
    (folder / "scans").mkdir()
    names = {"a": "ok", MARKUP.replace("/", ""): "weak", "z": "failed"}
    for name, status in names.items():
        text = json.dumps(interior_result(name, status))
        (folder / "out" / f"{name}.interior.json").write_text(text, encoding="utf-8")
        grey = bytes((col + row) % 256 for row in range(SIDE) for col in range(SIDE))
        (folder / "scans" / f"{name}.pgm").write_bytes(b"P5 %d %d 255\n" % (SIDE, SIDE) + grey)
    return list(names)


class Server:
    def __init__(self, process, address):
        self.process, self.address = process, address
        parts = urllib.parse.urlsplit(address)
        self.host, self.port, self.token = parts.hostname, parts.port, parts.path.strip("/")

    def ask(self, method, path, body=None, headers=None, token=None):
        """Returns (status, headers, body); `path` is relative to the token."""
        connection = http.client.HTTPConnection(self.host, self.port, timeout=60)
        try:
            head = {"Content-Type": "application/json"} if method == "POST" else {}
            connection.request(method, f"/{self.token if token is None else token}/{path}", body,
                               {**head, **(headers or {})})
            answer = connection.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            connection.close()

    def get(self, path):
        status, _, body = self.ask("GET", path)
        assert status == 200, (path, status, body)
        return json.loads(body)

    def say(self, word):
        """Returns the status."""
        word = {"version": self.get("api/list")["version"], **word}
        return self.ask("POST", "api/say", json.dumps(word))[0]


@contextlib.contextmanager
def running(orient, *words):
    process = subprocess.Popen([orient, "review", *map(str, words)], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    try:
        address = None
        for line in process.stdout:
            if line.startswith("review  "):
                address = line.split()[1]
                break
        assert address, process.stderr.read()
        yield Server(process, address)
    finally:
        process.kill()
        process.communicate()
