#!/usr/bin/env python3
"""CTest `neighbours_all` (slow): a failure in one photo does not change the results of the others.

    neighbours_test.py ORIENT INJECTOR [TRIES [SEED]]   TRIES: default 20

Four photos, two in parallel. `exterior` and `interior` find a folder in place of one photo's result
file; `block` finds a disk that is full from some call on (injector.cpp). Every result written must
be that of the undisturbed run, and so must all results after the command is repeated.
"""

import pathlib
import random
import shutil
import sys
import tempfile

from world import World, is_log

CPUS = (0, 1)
SUFFIXES = (".exterior.json", ".interior.json", ".ties.json")
BAD_INPUT, MACHINE = 2, 4


class Neighbours:
    def __init__(self, orient, injector, folder, chance):
        self.world, self.injector, self.chance = World(orient, folder / "start", folder / "here", 4), injector, chance
        self.world.make()
        self.commands = self.world.commands(2)
        # The roll is judged after all photos, which the failing one prevents here.
        self.commands["interior"].words += ["--roll", "differing"]
        self.expected, self.calls = {}, 0
        for name in ("exterior", "interior", "block"):
            self.world.renew(self.commands[name])
            done = self.run(name, told=folder)
            assert done.returncode == 0, done.stdout + done.stderr
            self.expected[name] = self.world.result()
        self.calls = int(dict(map(str.split, (folder / "calls").read_text().splitlines()))["write"])

    def run(self, name, words=(), **fault):
        return self.world.run([*self.commands[name].words, *words], self.injector, cpus=CPUS, **fault)

    def wrong(self, name, of_all):
        now, expected = self.world.result(), self.expected[name]
        # A block's final results follow those of the stages; only these are made photo by photo.
        names = now.keys() | expected.keys() if of_all else \
            [f for f in now if f.name.endswith(SUFFIXES) and (name != "block" or "stages" in f.parts)]
        return [str(f) for f in names if now.get(f) != expected.get(f) and not is_log(f)]

    def repeated(self, name):
        done = self.run(name, self.commands[name].again)
        return [f"exit code {done.returncode}: {done.stderr}"] * (done.returncode != 0) + self.wrong(name, True)

    def in_the_way(self, name):
        """A folder has the name of one photo's result file."""
        photo = self.chance.choice(self.world.photos)
        self.world.renew(self.commands[name])
        folder = self.world.here / f"out/{photo}.{name}.json"
        (folder / "in the way").mkdir(parents=True)
        done = self.run(name, self.commands[name].again)
        wrong = self.wrong(name, False)
        if done.returncode != BAD_INPUT or str(folder) not in done.stderr:
            wrong.append(f"exit code {done.returncode}: {done.stderr}")
        shutil.rmtree(folder)
        return wrong + self.repeated(name)

    def disk_full(self):
        self.world.renew(self.commands["block"])
        at = self.chance.randint(1, self.calls)
        done = self.run("block", kind="write", at=at, on=True)
        wrong = self.wrong("block", False)
        if done.returncode != MACHINE and wrong:
            wrong.append(f"exit code {done.returncode}: {done.stderr}")
        return wrong + self.repeated("block")


def main(orient, injector, tries, seed):
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as temporary:
        neighbours = Neighbours(orient, injector, pathlib.Path(temporary), chance)
        failed = 0
        for turn in range(tries):
            for name, trial in (("exterior", lambda: neighbours.in_the_way("exterior")),
                                ("interior", lambda: neighbours.in_the_way("interior")),
                                ("block", neighbours.disk_full)):
                wrong = trial()
                failed += bool(wrong)
                if wrong:
                    print(f"try {turn}, {name}:", *wrong, sep="\n  ", flush=True)
        print(f"{tries} tries of each, {failed} wrong")
        sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 20,
         int(sys.argv[4]) if len(sys.argv) > 4 else 1)
