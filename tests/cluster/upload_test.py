#!/usr/bin/env python3
"""CTest `upload`: `orient upload` copies a folder completely to a bucket, whatever the store does.

    upload_test.py ORIENT [--all]

Stores that refuse or do not answer make the program wait; --all tests them (CTest `upload_all`).
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from bucket_store import BucketStore

LIST = "orient-upload.json"
PLACE = "s3://archive/block 7"


def make_output(folder):
    """An output folder as left by a run, with one file larger than an upload part (below)."""
    files = {"block.json": b"{}\n", "empty.txt": b"", "Überblick (1).csv": b"photo,x\n",
             "stages/exterior/a b.json": b"1", "mosaic.tif": bytes(range(256)) * 50_000}
    files |= {f"photos/{i}.json": str(i).encode() for i in range(20)}
    for name, contents in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(contents)
    # Files that are not results.
    for name in ("block.json.1-1-0badcafe.part", ".orient-block.lock", "slurm/logs/upload.log",
                 "orient-upload.json"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(b"half")
    os.utime(folder / "block.json.1-1-0badcafe.part", (0, 0))  # of a machine that ended long ago
    files["photos/orient-upload.json"] = b"a photo of this name"
    (folder / "photos/orient-upload.json").write_bytes(files["photos/orient-upload.json"])
    (folder / "latest.json").symlink_to("photos/3.json")
    files["latest.json"] = b"3"
    return files


class Trial:
    def __init__(self, orient, folder, store):
        self.orient, self.out, self.store = orient, folder / "out", store
        self.bucket = folder / "store/archive"
        self.complaints = []

    def words(self, *options, out=None, place=PLACE):
        return [str(self.orient), "upload", f"{out or self.out}/", place, "--jobs", "2", *options]

    def environment(self):
        return self.store.environment() | {"VSIS3_CHUNK_SIZE": "5"}

    def upload(self, *options, code=0, says="", **where):
        run = subprocess.run(self.words(*options, **where), env=self.environment(), check=False,
                             capture_output=True, text=True)
        said = run.stdout + run.stderr
        if run.returncode != code or says not in said:
            self.complain(f"{options} {where}: {run.returncode}, expected {code} and '{says}': {said}")
        return said

    def complain(self, what):
        self.complaints.append(what)

    def expect(self, what, is_so):
        if not is_so:
            self.complain(what)

    def list(self):
        path = self.bucket / "block 7" / LIST
        return json.loads(path.read_text()) if path.exists() else None

    def objects(self):
        root = self.bucket / "block 7"
        return {str(path.relative_to(root)): path.read_bytes() for path in root.rglob("*")
                if path.is_file() and path != root / LIST}

    def begin(self, count, delay_s=0.1):
        """Starts an upload to a slow store and returns once `count` objects have been written."""
        self.store.delay_s = delay_s
        process = subprocess.Popen(self.words(), env=self.environment(), stderr=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, text=True)
        while len(self.store.written) < count and process.poll() is None:
            time.sleep(0.01)
        self.expect(f"ended before {count} objects were there", process.poll() is None)
        return process

    def expect_end(self, process, code, says):
        self.store.delay_s = 0
        error = process.communicate()[1]
        self.expect(f"{process.returncode}: {error}", process.returncode == code and says in error)

    def clear(self):
        subprocess.run(["rm", "-rf", str(self.bucket / "block 7")], check=True)
        self.store.written.clear()


def goes_whole(trial, files):
    trial.upload(says="sent 27 of 27 files")
    trial.expect("other objects than files", trial.objects() == files)
    listed = trial.list()
    trial.expect("the list is not complete", listed["complete"] and set(listed["files"]) == set(files))
    trial.expect("sizes in the list", all(listed["files"][name]["bytes"] == len(contents)
                                          for name, contents in files.items()))
    trial.expect("the list is not the last", trial.store.written[-1].endswith(LIST))
    trial.store.written.clear()
    trial.upload(says="sent 0 of 27 files")
    trial.expect("something was written again", not trial.store.written)


def replaces_only_when_told(trial, files):
    (trial.out / "block.json").write_bytes(b"{ }")
    trial.upload(code=1, says="s3://archive/block 7/block.json would be replaced")
    trial.expect("replaced without being told", trial.objects() == files)
    trial.upload("--overwrite", says="sent 1 of 27 files")
    trial.expect("not replaced", trial.objects() == files | {"block.json": b"{ }"})
    (trial.out / "block.json").write_bytes(files["block.json"])
    (trial.bucket / "block 7/mosaic.tif").write_bytes(b"of somebody else")
    trial.upload(code=1, says="block.json and 1 more would be replaced")
    trial.upload("--overwrite", says="sent 2 of 27 files")
    trial.expect("not restored", trial.objects() == files)
    trial.clear()
    trial.store.keep(trial.bucket / "block 7/block.json", b"somebody's")
    trial.upload(code=1, says="would be replaced")
    trial.expect("somebody's object", trial.objects() == {"block.json": b"somebody's"})


def survives_faults(trial, files):
    trial.clear()
    trial.store.busy, trial.store.cut = 0.15, 0.04
    trial.upload(says="sent 27 of 27 files")
    trial.expect("faults: other objects than files", trial.objects() == files)
    print(f"{trial.store.faults} faults, {trial.store.cuts} without an answer")
    trial.expect("no fault has occurred", trial.store.faults > 3 and trial.store.cuts > 0)
    trial.store.busy = trial.store.cut = 0


def goes_on_after_a_kill(trial, files):
    trial.clear()
    process = trial.begin(6, delay_s=0.05)
    process.kill()
    trial.expect_end(process, -signal.SIGKILL, "")
    trial.expect("killed, and complete", trial.list() is not None and not trial.list()["complete"])
    trial.upload(says="of 27 files")
    trial.expect("after a kill: other objects than files", trial.objects() == files)
    trial.expect("after a kill: not complete", trial.list()["complete"])


def ends_where_the_store_does(trial, files):
    trial.clear()
    process = trial.begin(8)
    trial.store.busy = 1
    trial.expect_end(process, 4, "the same command goes on")
    trial.expect("half of an object", all(files[name] == contents
                                          for name, contents in trial.objects().items()))
    trial.store.busy = 0
    trial.upload()
    trial.expect("after a refusal: other objects than files", trial.objects() == files)


def goes_on_where_it_ended(trial, files):
    trial.clear()
    trial.store.forbidden = "/19.json"
    said = trial.upload(code=4, says="photos/19.json")
    trial.expect(f"no remedy: {said}", "right to write" in said)
    there = sum("digest" in entry for entry in trial.list()["files"].values())
    trial.expect(f"{there} files in the list", 0 < there < len(files)
                 and not trial.list()["complete"])
    trial.store.forbidden = None
    trial.upload(says=f"sent {len(files) - there} of {len(files)} files")
    trial.expect("refused once: other objects than files", trial.objects() == files)


def takes_no_answer_for_no_object(trial, files):
    """For somebody else's object, if the store is busy, denies access, or does not answer."""
    name = trial.bucket / "block 7/block.json"
    for code, trial.store.plain in ((503, False), (503, True), (403, False), (403, True),
                                    (500, False), (None, False)):
        trial.clear()
        trial.store.keep(name, b"somebody's")
        trial.store.unanswered = ("block.json", code)
        trial.upload(code=2 if code == 403 else 4)
        trial.store.unanswered = None
        trial.expect(f"{code}: replaced", name.read_bytes() == b"somebody's")
    trial.upload(code=1, says="block.json would be replaced")
    trial.clear()
    trial.store.plain = True
    trial.upload(says="sent 27 of 27 files")
    trial.store.plain = False


def replaces_only_what_it_planned(trial, files):
    """After an interrupted upload of another folder, and after a complete one."""
    for complete in (False, True):
        trial.clear()
        trial.store.keep(trial.bucket / "block 7/block.json", b"another's")
        listed = {"kind": "orient upload", "id": "1", "complete": complete,
                  "files": {"other.json": {"bytes": 1}}}
        trial.store.keep(trial.bucket / "block 7" / LIST, json.dumps(listed).encode())
        trial.upload(code=1, says="would be replaced")
        (trial.bucket / "block 7/block.json").unlink()
        trial.upload(code=1, says=f"{LIST} would be replaced")
    # Arrived with that upload, but has been changed since.
    listed = {"kind": "orient upload", "id": "1", "complete": False,
              "files": {"block.json": {"bytes": 3, "digest": "c735ad1983dc7ddd"}}}
    trial.clear()
    trial.store.keep(trial.bucket / "block 7/block.json", b"somebody's")
    trial.store.keep(trial.bucket / "block 7" / LIST, json.dumps(listed).encode())
    trial.upload(code=1, says="block.json would be replaced")
    trial.upload("--overwrite")
    trial.expect("overwritten: other objects than files", trial.objects() == files)


def sees_that_an_object_was_not_put_together(trial, files):
    trial.clear()
    trial.store.half_said = True
    trial.upload(code=4, says="mosaic.tif")
    trial.expect("complete without an object", not trial.list()["complete"])
    trial.store.half_said = False
    trial.upload()
    trial.expect("put together: other objects than files", trial.objects() == files)
    # Nor if an older object is there.
    (trial.out / "mosaic.tif").write_bytes(files["mosaic.tif"][:-1] + b"!")
    trial.store.half_said = True
    trial.upload("--overwrite", code=4, says="mosaic.tif")
    trial.expect("complete with an old object", not trial.list()["complete"])
    trial.store.half_said = False
    (trial.out / "mosaic.tif").write_bytes(files["mosaic.tif"])


def notices_another_upload(trial, _):
    trial.clear()
    process = trial.begin(4)
    listed = trial.list() | {"id": "another"}
    trial.store.keep(trial.bucket / "block 7" / LIST, json.dumps(listed).encode())
    trial.expect_end(process, 2, "another upload")
    trial.expect("complete, or something is", not trial.list()["complete"]
                 and not any("digest" in entry for entry in trial.list()["files"].values()))


def notices_that_a_file_has_changed(trial, files):
    trial.clear()
    process = trial.begin(6)
    (trial.out / "block.json").write_bytes(b"[]\n")
    trial.expect_end(process, 2, "block.json has changed")
    (trial.out / "block.json").write_bytes(files["block.json"])
    trial.upload(says="sent 1 of 27 files")
    trial.expect("changed: other objects than files", trial.objects() == files)


def refuses_what_it_cannot_send_whole(trial, _):
    trial.clear()
    for name, make, says in (
            ("gone.json", lambda path: path.symlink_to("nowhere"), "gone.json cannot be uploaded"),
            ("linked", lambda path: path.symlink_to("photos"), "linked is a link to a folder"),
            ("pipe", os.mkfifo, "pipe cannot be uploaded"),
            ("a.json.1-1-0badcafe.part", pathlib.Path.touch, "is being written")):
        path = trial.out / name
        make(path)
        trial.upload(code=2, says=says)
        path.unlink()
    trial.expect("something was sent", not trial.store.written)
    pathlib.Path(trial.out.parent / "gdalrc").write_text(
        "[configoptions]\nCPL_VSIL_CURL_ALLOWED_EXTENSIONS=.tif\n")
    environment = trial.environment() | {"GDAL_CONFIG_FILE": str(trial.out.parent / "gdalrc")}
    blind = subprocess.run(trial.words(), env=environment, capture_output=True, text=True,
                           check=False)
    trial.expect(f"blind: {blind.returncode} {blind.stderr}",
                 blind.returncode == 1 and "ALLOWED_EXTENSIONS" in blind.stderr)


def refuses(trial, _):
    for place in ("http://user:secret@host/out", "s3://", "s3:///a", "s3://a//b", "s3://a/../b",
                  "gs://a/b?token=c", "out"):
        said = trial.upload(code=1, says="not in object storage", place=place)
        trial.expect("secret told", "secret" not in said)
    trial.upload(code=2, says="is not a folder", out=trial.out / "nothing")
    (trial.out / "nothing").mkdir()
    trial.upload(code=2, says="holds no results", out=trial.out / "nothing")
    (trial.out / "stages/unfinished").write_text("")
    trial.upload(code=2, says="has not ended")
    (trial.out / "stages/unfinished").unlink()
    trial.store.keep(trial.bucket / "block 7" / LIST, b"[]")
    trial.upload(code=2, says="is not a list of an upload")
    nobody = {key: value for key, value in trial.environment().items() if not key.startswith("AWS_")}
    nobody |= {"AWS_CONFIG_FILE": "/nowhere", "CPL_AWS_AUTODETECT_EC2": "NO", "HOME": "/nowhere"}
    run = subprocess.run(trial.words(), env=nobody, capture_output=True, text=True, check=False)
    trial.expect(f"without credentials: {run.returncode} {run.stderr}",
                 run.returncode == 2 and "credentials" in run.stderr)


QUICK = (goes_whole, replaces_only_when_told, survives_faults, goes_on_after_a_kill,
         refuses_what_it_cannot_send_whole)
SLOW = (ends_where_the_store_does, goes_on_where_it_ended, takes_no_answer_for_no_object,
        replaces_only_what_it_planned, sees_that_an_object_was_not_put_together,
        notices_another_upload, notices_that_a_file_has_changed, refuses)


def main(orient, *everything):
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "store/archive").mkdir(parents=True)
        files = make_output(folder / "out")
        with BucketStore(folder / "store") as store:
            trial = Trial(pathlib.Path(orient).resolve(), folder, store)
            for part in QUICK + (SLOW if everything else ()):
                part(trial, files)
            print(f"{store.requests} requests, {store.faults} faults")
    print("\n".join(trial.complaints) or "a folder is uploaded whole")
    return 1 if trial.complaints else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
