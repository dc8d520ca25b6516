#!/usr/bin/env python3
"""Mutation testing: do the tests notice deliberate mistakes?

    mutate.py MODULE|NAME ...   makes mutants (all of a module, or those whose name contains the
                                text), one at a time, and shows which test kills each; known results
                                are reused as long as the mutated source, the name and the list of
                                tests are unchanged
    mutate.py --all             all of them
    mutate.py --part K/N ...    of those chosen, the K-th, the (K+N)-th and so on, in a copy of the
                                sources of their own: parts may run side by side
    mutate.py --self-test       checks that every mutant can still be made

A mutant replaces a piece of text in one source; the tables beside this file, <module>.toml, list
them. It is made in a copy of the sources (build/mutation, or build/mutation_K), where only what
depends on it is built again. It may be killed by the compiler; by tests of the source's own test
file, then of its module, then of the modules above, until one fails; or by a test that runs for
more than ten minutes. A mutant with a `reason` is known to survive; the reason says why that does
no harm.
"""

import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TABLES = ROOT / "tests/mutation"
LEAST = 120
# Tests that run the program from outside: their arguments after it, and what else they need.
INJECTOR = ["tests/liborient_injector.so"]
SCRIPTS = {"upload": ("cluster/upload_test.py", [], ["--all"]),
           "faults": ("faults/faults_test.py", INJECTOR, []),
           "block_kill": ("block/kill_test.py", INJECTOR, []),
           "patchdb_kill": ("patchdb/kill_test.py", ["tests/patchdb_learner", *INJECTOR], [])}
# The tests of each module, its own first.
TESTS = {"core": ["test_core", "fuzz_corpus", "test_patchdb", "faults", "test_interior",
                  "test_exterior", "test_tools", "upload", "test_block", "test_end_to_end"],
         "interior": ["test_interior", "test_block", "test_tools", "test_end_to_end"],
         "patchdb": ["test_patchdb", "fuzz_corpus", "patchdb_kill", "test_exterior", "test_tools",
                     "test_block", "test_end_to_end"],
         "exterior": ["test_exterior", "test_block", "test_end_to_end"],
         "block": ["test_block", "block_kill", "test_tools", "test_end_to_end"],
         "tools": ["test_tools", "upload", "faults", "test_block", "test_end_to_end"]}
MOST_SECONDS = 600
QUICK = "-Slow*:*/Slow*"


def mutants():
    """All mutants of the tables, each with its module (`room`)."""
    found = []
    for room in TESTS:
        with open(TABLES / f"{room}.toml", "rb") as file:
            found += [{**mutant, "room": room} for mutant in tomllib.load(file)["mutant"]]
    return found


def mutated(mutant):
    """The text of the source with the mutant in it."""
    text = (ROOT / mutant["file"]).read_text(encoding="utf-8")
    count = text.count(mutant["old"])
    if count != 1:
        raise ValueError(f"{mutant['name']}: its text occurs {count} times in {mutant['file']}")
    return text.replace(mutant["old"], mutant["new"])


def self_test():
    wrong = []
    all_of_them = mutants()
    for mutant in all_of_them:
        try:
            if mutated(mutant) == (ROOT / mutant["file"]).read_text(encoding="utf-8"):
                wrong.append(f"{mutant['name']}: changes nothing")
        except (OSError, ValueError) as error:
            wrong.append(str(error))
        if not mutant["file"].startswith(mutant["room"] + "/"):
            wrong.append(f"{mutant['name']}: {mutant['file']} is not of {mutant['room']}")
    names = [mutant["name"] for mutant in all_of_them]
    wrong += [f"{name}: twice" for name in sorted(set(names)) if names.count(name) > 1]
    if len(names) < LEAST:
        wrong.append(f"{len(names)} mutants; at least {LEAST}")
    print("\n".join(wrong) or f"{len(names)} mutants can be made")
    return 1 if wrong else 0


def own_suites(mutant):
    """A filter for the suites of the source's own test file; empty if it has none."""
    stem = pathlib.Path(mutant["file"]).with_suffix("")
    suites = set()
    for path in (ROOT / "tests" / stem.parent).glob(f"{stem.name}*_test.cpp"):
        suites |= set(re.findall(r"^(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\((\w+),",
                                 path.read_text(encoding="utf-8"), re.MULTILINE))
    return ":".join(f"{suite}.*:*/{suite}.*" for suite in sorted(suites))


def needed(test):
    """What must be built for a test."""
    if test in SCRIPTS:
        return ["orient", *SCRIPTS[test][1]]
    return ["orient", test] if test == "test_end_to_end" else [test]


def digest_of(mutant):
    what = [mutated(mutant), mutant["name"], TESTS[mutant["room"]]]
    return hashlib.sha256(json.dumps(what).encode()).hexdigest()


class Copy:
    """A copy of the sources, its build tree and the results known there."""

    def __init__(self, place):
        self.place, self.sources, self.tree = place, place / "sources", place / "build"
        self.record = place / "killed.json"
        self.known = {}
        if self.record.exists():
            self.known = json.loads(self.record.read_text(encoding="utf-8"))
        self.refresh()
        if not self.tree.exists():
            subprocess.run(["cmake", "-S", self.sources, "-B", self.tree, "-G", "Ninja",
                            "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG"],
                           check=True, stdout=subprocess.DEVNULL)

    def refresh(self):
        """Copies only files that differ: unchanged ones keep their times, thus their objects."""
        names = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard"],
                               check=True, capture_output=True, text=True).stdout.split("\n")
        for name in filter(None, names):
            there, here = self.sources / name, (ROOT / name).read_bytes()
            if not there.exists() or there.read_bytes() != here:
                there.parent.mkdir(parents=True, exist_ok=True)
                there.write_bytes(here)

    def run(self, line, log, seconds=None):
        """The exit code; None after a timeout."""
        with open(self.place / log, "w", encoding="utf-8") as file:
            try:
                return subprocess.run(line, stdout=file, stderr=file, check=False, cwd=self.sources,
                                      timeout=seconds).returncode
            except subprocess.TimeoutExpired:
                return None

    def build(self, targets):
        return self.run(["cmake", "--build", self.tree, "-j", str(os.cpu_count()), "--target",
                         *targets], "build.log") == 0

    def failing_test(self, test, only=""):
        """Name of the first failing test; empty if all pass."""
        log = "test.log"
        if test in SCRIPTS:
            script, built, options = SCRIPTS[test]
            code = self.run([sys.executable, self.sources / "tests" / script, self.tree / "orient",
                             *(self.tree / name for name in built), *options], log, MOST_SECONDS)
            return "" if code == 0 else test + (" hangs" if code is None else "")
        if not test.startswith("test_"):
            code = self.run([self.tree / f"tests/fuzz/{test}", self.sources / "tests/fuzz/corpus"],
                            log, MOST_SECONDS)
            return "" if code == 0 else test
        code = self.run([self.tree / f"tests/{test}",
                         f"--gtest_filter={only}{QUICK if only else '*' + QUICK}",
                         "--gtest_fail_fast", "--gtest_brief=1"], log, MOST_SECONDS)
        if code == 0:
            return ""
        text = (self.place / log).read_text(encoding="utf-8", errors="replace")
        failed = re.search(r"^\[  FAILED  \] ([^\s,]+)", text, re.MULTILINE)
        if failed:
            return failed.group(1)
        return f"{test} " + ("hangs" if code is None else "ends early")

    def killer(self, mutant):
        """What kills a mutant; None if nothing does."""
        for place, test in enumerate(TESTS[mutant["room"]]):
            if not self.build(needed(test)):
                return "the compiler"
            suites = own_suites(mutant) if place == 0 else ""
            found = (self.failing_test(test, suites) if suites else "") or self.failing_test(test)
            if found:
                return found
        return None

    def judge(self, mutant):
        """What kills a mutant, from the record if that is known."""
        digest = digest_of(mutant)
        if digest not in self.known:
            start, path = time.monotonic(), self.sources / mutant["file"]
            whole = path.read_bytes()
            try:
                path.write_text(mutated(mutant), encoding="utf-8")
                self.known[digest] = {"by": self.killer(mutant),
                                      "seconds": round(time.monotonic() - start)}
            finally:
                path.write_bytes(whole)
            self.record.write_text(json.dumps(self.known, indent=1), encoding="utf-8")
        return self.known[digest]["by"]


def judge(chosen, place):
    copy = Copy(place)
    killed = survivors = 0
    for mutant in chosen:
        by = copy.judge(mutant)
        killed += by is not None
        survivors += by is None and "reason" not in mutant
        print(f"{mutant['room']:9} {mutant['name']:65} "
              + (by or ("SURVIVES" if "reason" not in mutant else f"survives: {mutant['reason']}")),
              flush=True)
    print(f"{killed} of {len(chosen)} mutants killed, {survivors} survive without a reason")
    return 1 if survivors else 0


def main(words):
    if not words:
        sys.exit(__doc__)
    if words == ["--self-test"]:
        return self_test()
    part, parts, place = 1, 1, ROOT / "build/mutation"
    if words[0] == "--part":
        part, parts = (int(number) for number in words[1].split("/"))
        place, words = ROOT / f"build/mutation_{part}", words[2:]
        if not words or not 1 <= part <= parts:
            sys.exit(__doc__)
    chosen = [mutant for mutant in mutants()
              if words == ["--all"] or any(word == mutant["room"] or word in mutant["name"]
                                           for word in words)]
    return judge(chosen[part - 1::parts], place)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
