#!/usr/bin/env python3
"""CTest `faults` (quick) and `faults_everywhere` (slow): the machine fails at the n-th call.

    faults_test.py ORIENT INJECTOR [--everywhere [K/N] | --every [K/N]] [--only COMMAND]
                   [--kind KIND] [--at N] [--threads N]

Every command that reads or writes files runs undisturbed, and then repeatedly with one failing call
(injector.cpp), or with all calls failing from one on ("write+"). By default, one call of one kind
fails; with --everywhere, the first call of each path through the program (for "write+", of every
third path); with --every, each single call. Both take hours; 3/8 selects the third, the eleventh
... of these.
Undisturbed, all files must be flushed before they are renamed, and their folders afterwards.
After a fault, the exit code must be as documented, the message must name a file, and no file may be
wrong or left over; the same command, run again, must give the undisturbed result to the last byte.
On one thread, a case can be repeated with --only, --kind and --at. --processes: number of cases
tried in parallel.
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import sys
import tempfile
import zlib

from world import World, holds_changes, is_log, without_times

KINDS = ["write", "write+", "read", "memory"]
DONE, BAD_INPUT, MACHINE = 0, 2, 4
# Files that mark a run as unfinished.
IN_PROGRESS = {"unfinished", "unfinished_simulation", "not_yet_learnt", "not_yet_divided"}


class Cases:
    """The faults of one command in one copy of the world."""

    def __init__(self, world, injector, name, threads, first_cpu=0):
        self.world, self.injector, self.name = world, injector, name
        self.cpus = {(first_cpu + i) % os.cpu_count() for i in range(threads)}
        self.command = world.commands(threads)[name]
        told = world.here.parent / f"told_of_{world.here.name}"
        told.mkdir(exist_ok=True)
        done = self.run("none", 0, told)
        assert done.returncode == DONE, f"{name}: {done.stdout}{done.stderr}"
        self.expected, self.said = world.result(), without_times(done.stdout)
        self.places = collections.defaultdict(list)  # call paths by kind
        self.unflushed = (told / "unflushed").read_text().splitlines()
        for kind, place in map(str.split, (told / "places").read_text().splitlines()):
            self.places[kind].append(place)
        for kind, calls in map(str.split, (told / "calls").read_text().splitlines()):
            assert len(self.places[kind]) == int(calls), f"{name}: {calls} are too many to be told apart"

    def run(self, kind, at, told=None):
        self.world.renew(self.command)
        return self.world.run(self.command.words, self.injector, kind.rstrip("+"), at, kind.endswith("+"),
                              told, told is not None, self.cpus)

    def calls(self, kind):
        return len(self.places[kind.rstrip("+")])

    def first_of_each_way(self, kind):
        first = {}
        for at, place in enumerate(self.places[kind.rstrip("+")], 1):
            first.setdefault(place, at)
        # Failures of all calls from one on hardly differ from those from the next one on.
        return list(first.values())[::3 if kind.endswith("+") else 1]

    def chosen(self, kind, asked):
        calls = self.calls(kind)
        if share := asked.everywhere or asked.every:
            of = self.first_of_each_way(kind) if asked.everywhere else range(1, calls + 1)
            first, step = map(int, share.split("/"))
            return of[first - 1::step]
        chance = zlib.crc32(f"{self.name} {kind}".encode())
        known = [one for one in KINDS if self.calls(one) > 0]
        mine = known[zlib.crc32(self.name.encode()) % len(known)]
        return [chance % calls + 1] if kind == mine else []

    def try_one(self, kind, at):
        """The exit code, and what is wrong after call number `at` of this kind has failed."""
        done = self.run(kind, at)
        text = (done.stdout + done.stderr).strip()[-300:]
        wrong = list(self.wrong_after(kind, done))
        if done.returncode != DONE:
            again = self.world.run([*self.command.words, *self.command.again], cpus=self.cpus)
            if again.returncode != DONE:
                wrong.append(f"cannot be repeated: {again.stderr.strip()[-300:]}")
            wrong += [f"{file} is left in the end" for file in self.world.files() if is_log(file)]
            wrong += [f"{file} differs in the end" for file in self.differing()]
        return done.returncode, [f"{self.name}, {kind} {at}: {line} ({text})" for line in wrong]

    def wrong_after(self, kind, done):
        if done.returncode not in (DONE, BAD_INPUT, MACHINE):
            yield f"exit code {done.returncode}"
        if done.returncode != DONE and str(self.world.here) not in done.stderr \
                and "memory" not in done.stderr:
            yield "no file is named"
        if "internal error" in done.stdout + done.stderr:
            yield "an internal error"
        for file in self.world.files() - self.expected.keys():
            kept = done.returncode != DONE or kind == "write+" or not holds_changes(self.world.here / file)
            if file.name not in IN_PROGRESS and not (is_log(file) and kept):
                yield f"{file} is left"
        if done.returncode == DONE:
            yield from (f"exit code 0 and another {file}" for file in self.differing())
            if without_times(done.stdout) != self.said:
                yield "exit code 0 and another output"

    def differing(self):
        now = self.world.result()
        return sorted(str(f) for f in now.keys() | self.expected.keys() if now.get(f) != self.expected.get(f))


def work(asked, start, number):
    """Tries every asked.processes-th case, beginning with `number`: (tried, wrong)."""
    tried = wrong = place = 0
    for name in [asked.only] if asked.only else World(asked.orient, start, start).commands(1):
        cases = Cases(World(asked.orient, start, start.parent / f"here{number}"), asked.injector, name,
                      asked.threads, number)
        if number == 0:
            for line in cases.unflushed:
                print(f"{name}: {line}", flush=True)
            wrong += len(cases.unflushed)
        for kind in [asked.kind] if asked.kind else KINDS:
            codes = collections.Counter()
            for at in [asked.at] if asked.at else cases.chosen(kind, asked):
                place += 1
                if place % asked.processes != number:
                    continue
                code, lines = cases.try_one(kind, at)
                codes[code] += 1
                wrong += bool(lines)
                for line in lines:
                    print(line, flush=True)
            tried += codes.total()
            print(f"{name}, {kind}: {codes.total()} tried of {cases.calls(kind)}; exit codes "
                  f"{dict(codes)}", flush=True)
    return tried, wrong


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("orient")
    parser.add_argument("injector")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--everywhere", nargs="?", const="1/1")
    which.add_argument("--every", nargs="?", const="1/1")
    parser.add_argument("--only")
    parser.add_argument("--kind")
    parser.add_argument("--at", type=int)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--processes", type=int, default=1)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        start = pathlib.Path(temporary) / "start"
        World(asked.orient, start, start).make()
        with concurrent.futures.ThreadPoolExecutor(asked.processes) as pool:
            done = list(pool.map(lambda number: work(asked, start, number), range(asked.processes)))
    tried, wrong = (sum(column) for column in zip(*done))
    print(f"{tried} faults, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
