"""A bucket of an object store (the part of the S3 interface that GDAL uses), as slow and unreliable
as object_store.py. Objects are files under FOLDER/<bucket>; credentials are not checked.

    with BucketStore(folder, busy=0.05) as store: run(..., env=store.environment())
"""

import os
import re
import time
import urllib.parse
from xml.sax.saxutils import escape

from object_store import Handler, ObjectStore


class BucketHandler(Handler):
    def do_HEAD(self):
        if not self.unanswered():
            super().do_HEAD()

    def do_GET(self):
        if self.unanswered():
            return None
        query = self.query()
        if "prefix" in query or "delimiter" in query:
            return self.list_objects(query)
        return super().do_GET()

    def do_PUT(self):
        return self.take(self.body(), self.query())

    def do_POST(self):
        body, query, store = self.body(), self.query(), self.server.store
        if self.refused():
            return None
        if "uploads" in query:
            with store.lock:
                store.pieces[str(len(store.pieces))] = {}
                number = len(store.pieces) - 1
            return self.send_xml("<InitiateMultipartUploadResult>"
                                 f"<UploadId>{number}</UploadId></InitiateMultipartUploadResult>")
        if store.half_said:
            return self.send_xml("<Error><Code>InternalError</Code></Error>")
        pieces = store.pieces[query["uploadId"][0]]
        order = [int(n) for n in re.findall(rb"<PartNumber>(\d+)</PartNumber>", body)]
        store.keep(self.object_path(), b"".join(pieces[n] for n in order))
        return self.send_xml("<CompleteMultipartUploadResult/>")

    def do_DELETE(self):
        self.object_path().unlink(missing_ok=True)
        self.end(204)

    def end(self, code):
        """Ends with the body in which S3 explains an error; `plain` stores send none."""
        if code < 400 or self.server.store.plain or self.command == "HEAD":
            return super().end(code)
        word = {403: "AccessDenied", 404: "NoSuchKey", 503: "SlowDown"}.get(code, "InternalError")
        return self.send_xml(f"<Error><Code>{word}</Code><Message>The words of {word}.</Message>"
                             "</Error>", code)

    def body(self):
        return self.rfile.read(int(self.headers.get("Content-Length", 0)))

    def query(self):
        return urllib.parse.parse_qs(urllib.parse.urlsplit(self.path).query, keep_blank_values=True)

    def unanswered(self):
        """Whether this request is for the `unanswered` object; if so, refuses it or hangs up."""
        name, code = self.server.store.unanswered or (None, None)
        if not name or not urllib.parse.urlsplit(self.path).path.endswith("/" + name):
            return False
        if code:
            self.end(code)
        else:
            self.close_connection = True
        return True

    def object_path(self):
        name = urllib.parse.unquote(urllib.parse.urlsplit(self.path).path).lstrip("/")
        return self.server.store.folder / name

    def refused(self):
        store = self.server.store
        time.sleep(store.delay_s)
        fault = store.next_fault()
        if fault == "busy":
            self.end(store.code)
        elif fault == "cut":  # the body is lost, and no answer is sent
            store.cuts += 1
            self.close_connection = True
        return fault is not None

    def take(self, body, query):
        store = self.server.store
        if self.refused():
            return
        if store.forbidden and store.forbidden in self.path:
            self.end(403)
            return
        if "partNumber" in query:
            store.pieces[query["uploadId"][0]][int(query["partNumber"][0])] = body
        else:
            store.keep(self.object_path(), body)
        self.send_response(200)
        self.send_header("ETag", '"0"')
        self.send_header("Content-Length", "0")
        self.end_headers()

    def list_objects(self, query):
        bucket = self.object_path()
        prefix = query.get("prefix", [""])[0]
        found = {str(path.relative_to(bucket)): path.stat().st_size
                 for path in sorted(bucket.rglob("*")) if path.is_file()}
        entries = "".join(f"<Contents><Key>{escape(name)}</Key><Size>{size}</Size></Contents>"
                          for name, size in found.items() if name.startswith(prefix))
        self.send_xml(f"<ListBucketResult><Prefix>{escape(prefix)}</Prefix>"
                      f"<IsTruncated>false</IsTruncated>{entries}</ListBucketResult>")

    def send_xml(self, text, code=200):
        body = ('<?xml version="1.0" encoding="UTF-8"?>\n' + text).encode()
        self.send_response(code)
        self.send_header("Content-Type", "application/xml")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


class BucketStore(ObjectStore):
    def __init__(self, folder, **faults):
        super().__init__(folder, handler=BucketHandler, **faults)
        self.plain = False  # errors without an explanation
        self.forbidden = None  # objects with this in their names must not be written
        self.unanswered = None  # (end of a name, code that requests for it get; None: no answer)
        self.half_said = False  # multipart uploads are not completed, although the code is 200
        self.pieces = {}  # parts of multipart uploads
        self.written = []  # the objects, in the order of writing

    def keep(self, path, contents):
        with self.lock:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(contents)
            self.written.append(str(path.relative_to(self.folder)))

    def environment(self):
        return dict(os.environ, AWS_S3_ENDPOINT=self.url.removeprefix("http://"), AWS_HTTPS="NO",
                    AWS_VIRTUAL_HOSTING="FALSE", AWS_ACCESS_KEY_ID="somebody",
                    AWS_SECRET_ACCESS_KEY="secret", GDAL_HTTP_RETRY_DELAY="0.02")
