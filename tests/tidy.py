#!/usr/bin/env python3
"""Runs clang-tidy on all sources within a time limit; sources known to be clean are skipped.

    tidy.py BUILD [--seconds N] [--since REF] [SOURCE ...]   with BUILD/compile_commands.json
    tidy.py --self-test                  checks that nothing untidy is taken for clean

A clean source is known by a digest of its text, of all project headers that it includes, of its
compile command, of .clang-tidy and of the tool's version: a file of that name in the cache,
$ORIENT_TIDY_CACHE or ~/.cache/orient-tidy. (Headers of other libraries are not part of the digest.)
Sources changed since REF come first (default: the point where the branch left origin/main, else the
previous commit), then those that include a changed header. After N seconds no more sources are
checked; those left over are named, and checked in a later run. The exit code is 1 if a changed
source is untidy; findings in unchanged sources are only printed, to be fixed with the next change
to them.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
FORGOTTEN_DAYS = 60  # entries not asked for as long are removed from the cache
AT_A_TIME = 2
TOOL = "clang-tidy-14"


def default_cache():
    beside = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return pathlib.Path(os.environ.get("ORIENT_TIDY_CACHE") or f"{beside}/orient-tidy")


def git(root, *words):
    done = subprocess.run(["git", "-C", root, *words], capture_output=True, text=True, check=False)
    return done.stdout.split() if done.returncode == 0 else []


def changed_since(root, ref):
    """Paths changed since `ref`; all tracked files if there is nothing to compare with."""
    head = git(root, "rev-parse", "HEAD")
    base = git(root, "rev-parse", ref) if ref else git(root, "merge-base", "HEAD", "origin/main")
    if not base or base == head:
        base = git(root, "rev-parse", "--verify", "-q", "HEAD~1")
    # Compared with the working tree, so that it also works before a commit.
    return set(git(root, "diff", "--name-only", *base[:1]) if base else git(root, "ls-files"))


class Project:
    """The sources under a root: what each includes, and the digest that clean ones are known by."""

    def __init__(self, root, build, tool=TOOL):
        self.root, self.build, self.tool = pathlib.Path(root), pathlib.Path(build), tool
        self.included = {}
        version = subprocess.run([tool, "--version"], capture_output=True, text=True, check=True)
        self.rules = version.stdout + (self.root / ".clang-tidy").read_text(encoding="utf-8")
        self.commands = {}
        with open(self.build / "compile_commands.json", encoding="utf-8") as file:
            for entry in json.load(file):
                # Independent of the location of sources and build tree.
                command = entry["command"].replace(str(self.build), "BUILD")
                self.commands[entry["file"]] = command.replace(str(self.root), "ROOT")

    def headers_of(self, path):
        """The project headers that a file includes directly, as paths from the root."""
        if path not in self.included:
            text = (self.root / path).read_text(encoding="utf-8")
            self.included[path] = [name for name in INCLUDE.findall(text)
                                   if (self.root / name).is_file()]
        return self.included[path]

    def all_headers_of(self, path):
        known, todo = set(), [path]
        while todo:
            todo += [header for header in self.headers_of(todo.pop()) if header not in known]
            known.update(todo)
        return known

    def digest_of(self, source):
        digest = hashlib.sha256(self.rules.encode())
        digest.update(self.commands.get(str(self.root / source), "").encode())
        for path in [source, *sorted(self.all_headers_of(source))]:
            digest.update(path.encode() + b"\0" + (self.root / path).read_bytes() + b"\0")
        return digest.hexdigest()

    def in_order(self, sources, changed):
        """Changed sources first, then those that include changed headers."""
        def place(source):
            return (source not in changed, not self.all_headers_of(source) & changed, source)
        return sorted(sources, key=place)

    def complaints_about(self, source):
        done = subprocess.run([self.tool, "--quiet", "-p", str(self.build), str(self.root / source)],
                              capture_output=True, text=True, check=False)
        return "" if done.returncode == 0 else done.stdout or done.stderr or "untidy"


class Cache:
    """Digests of clean sources: empty files whose times say when they were last asked for."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        oldest = time.time() - FORGOTTEN_DAYS * 24 * 3600
        for file in self.folder.iterdir():
            if file.stat().st_mtime < oldest:
                file.unlink(missing_ok=True)

    def has(self, digest):
        if not (self.folder / digest).exists():
            return False
        self.add(digest)
        return True

    def add(self, digest):
        (self.folder / digest).touch()


def look(project, cache, sources, changed, seconds):
    """Returns (known to be clean, checked, {untidy: why}, not checked)."""
    deadline = time.monotonic() + seconds
    digests = {source: project.digest_of(source) for source in sources}
    known = [source for source in sources if cache.has(digests[source])]
    todo = project.in_order(set(sources) - set(known), changed)
    untidy, left = {}, []

    def look_at(source):
        if time.monotonic() >= deadline:
            left.append(source)
            return
        why = project.complaints_about(source)
        if why:
            untidy[source] = why
            print(f"untidy: {source}\n{why}", flush=True)
        else:
            cache.add(digests[source])

    with concurrent.futures.ThreadPoolExecutor(AT_A_TIME) as pool:
        list(pool.map(look_at, todo))
    return known, [source for source in todo if source not in left], untidy, sorted(left)


def main(words):
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--seconds", type=float, default=480)
    parser.add_argument("--since", default=os.environ.get("ORIENT_CI_BASE"))
    parser.add_argument("sources", nargs="*")
    options = parser.parse_intermixed_args(words)
    root = pathlib.Path(__file__).resolve().parent.parent
    project = Project(root, pathlib.Path(options.build).resolve())
    sources = options.sources or git(root, "ls-files", "*.cpp")
    changed = changed_since(root, options.since)
    known, looked_at, untidy, left = look(project, Cache(default_cache()), sources, changed,
                                          options.seconds)
    for source in left:
        print(f"not checked for lack of time: {source}")
    print(f"{len(sources)} sources: {len(known)} known to be clean, {len(looked_at)} checked, "
          f"{len(untidy)} untidy, {len(left)} not checked for lack of time")
    return 1 if changed & untidy.keys() else 0


# --self-test: a tree of three sources, and a tool that complains about the word BAD.
TOOL_TEXT = """#!/bin/sh
[ "$1" != --version ] || { echo made up; exit; }
for last; do :; done
echo "$last" >>"$(dirname "$0")/log"
! grep BAD "$last"
"""
TREE = {"a/one.cpp": '#include "a/one.h"\n', "a/two.cpp": "int two;\n",
         "b/three.cpp": '#include "b/through.h"\n', "a/one.h": "int one;\n",
         "b/through.h": '#include "a/one.h"\n', ".clang-tidy": "Checks: all\n",
         "build/compile_commands.json": "[]"}
SOURCES = ["a/one.cpp", "a/two.cpp", "b/three.cpp"]


class SelfTest:
    def __init__(self, folder):
        self.root, self.wrong = pathlib.Path(folder), []
        for name, text in {**TREE, "tool": TOOL_TEXT}.items():
            self.write(name, text)
        (self.root / "tool").chmod(0o755)

    def write(self, name, text):
        (self.root / name).parent.mkdir(exist_ok=True)
        (self.root / name).write_text(text, encoding="utf-8")

    def expect(self, what, looked_at, untidy=(), left=(), changed=(), seconds=60):
        (self.root / "log").write_text("", encoding="utf-8")
        project = Project(self.root, self.root / "build", str(self.root / "tool"))
        _, looked, found, not_looked = look(project, Cache(self.root / "cache"), SOURCES,
                                            set(changed), seconds)
        seen = sorted((self.root / "log").read_text(encoding="utf-8").split())
        if (looked, sorted(found), not_looked) != (list(looked_at), list(untidy), list(left)) \
                or seen != sorted(str(self.root / source) for source in looked_at):
            self.wrong.append(f"{what}: {looked}, {sorted(found)}, {not_looked}")

    def run(self):
        self.expect("no time", [], left=SOURCES, seconds=0)
        self.expect("first run", ["b/three.cpp", "a/one.cpp", "a/two.cpp"],
                    changed=["b/three.cpp", "a/one.h"])
        self.expect("second run", [])
        self.write("a/one.h", "int uno;\n")
        self.expect("a header, also through another", ["a/one.cpp", "b/three.cpp"])
        self.write("a/two.cpp", "BAD\n")
        self.expect("what is untidy", ["a/two.cpp"], untidy=["a/two.cpp"])
        self.expect("what is still untidy", ["a/two.cpp"], untidy=["a/two.cpp"])
        self.write("a/two.cpp", "int two;\n")
        self.expect("as before", [])
        self.write("build/compile_commands.json",
                   json.dumps([{"file": f"{self.root}/a/two.cpp", "command": "c++ -DNEW"}]))
        self.expect("compiled in another way", ["a/two.cpp"])
        self.write(".clang-tidy", "Checks: more\n")
        self.expect("other checks", SOURCES)
        self.write("tool", TOOL_TEXT.replace("made up", "newer"))
        self.expect("another tool", SOURCES)
        os.utime(next((self.root / "cache").iterdir()), (0, 0))
        Cache(self.root / "cache")
        if any(file.stat().st_mtime == 0 for file in (self.root / "cache").iterdir()):
            self.wrong.append("the cache forgets nothing")
        return self.wrong


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        with open(os.devnull, "w", encoding="utf-8") as nowhere:
            out, sys.stdout = sys.stdout, nowhere
            wrong = SelfTest(folder).run()
            sys.stdout = out
    print("\n".join(wrong) or "what changed is looked at, and nothing else")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(self_test() if sys.argv[1:] == ["--self-test"] else main(sys.argv[1:]))
