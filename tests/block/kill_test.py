#!/usr/bin/env python3
"""CTest `block_kill` (quick) and `block_kill_all` (slow): a block survives kill -9 at any call.

    kill_test.py ORIENT INJECTOR [KILLS [SEED]]

KILLS: number of blocks with a kill, default 3; SEED: determines at which calls. A small simulated
block is oriented without disturbance, with quicklook, export and a patch database that learns. This
is then repeated: each time, the program is killed at a call that writes
(tests/faults/injector.cpp), with half of the data in the file; every third time, it is killed again
after resuming; then it is left to finish. The contents of the folders and of the patch database
must be the same to the last byte, except for times of day, and there must be no other files.
"""

import collections
import pathlib
import random
import signal
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "faults"))
from world import World, is_log  # noqa: E402


class Kills:
    def __init__(self, orient, injector, folder):
        self.world, self.injector = World(orient, folder / "start", folder / "here"), injector
        self.world.make()
        self.command = self.world.commands(1)["block"]
        self.words = [*self.command.words, "--quicklook"]
        self.world.renew(self.command)
        done = self.world.run(self.words, injector, told=folder)
        assert done.returncode == 0, done.stderr
        assert not (folder / "unflushed").read_text(), (folder / "unflushed").read_text()
        self.calls = dict(map(str.split, (folder / "calls").read_text().splitlines()))
        self.expected = self.world.result()

    def kill(self, call):
        """Whether the run was killed: a resumed run has less to do and may finish before."""
        done = self.world.run([*self.words, "--resume"], self.injector, "kill", call)
        assert done.returncode in (0, -signal.SIGKILL), done.stderr
        return done.returncode != 0

    def wrong_in_the_end(self):
        done = self.world.run([*self.words, "--resume"])
        if done.returncode != 0:
            yield f"exit code {done.returncode}: {done.stderr}"
        yield from (f"{file} is left" for file in self.world.files() if is_log(file))
        now = self.world.result()
        yield from (f"{file} differs" for file in sorted(now.keys() | self.expected.keys())
                    if now.get(file) != self.expected.get(file))


def main(orient, injector, kills, seed):
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as temporary:
        kills_of = Kills(orient, injector, pathlib.Path(temporary))
        last = int(kills_of.calls["kill"])
        wrong, counts = [], collections.Counter()
        for turn in range(kills):
            # Spread over the run: one kill in each of `kills` equal parts.
            first = chance.randint(turn * last // kills + 1, (turn + 1) * last // kills)
            calls = [first] + ([chance.randint(1, last)] if turn % 3 == 2 else [])
            kills_of.world.renew(kills_of.command)
            killed = [call for call in calls if kills_of.kill(call)]
            counts[len(killed)] += 1
            found = list(kills_of.wrong_in_the_end())
            if found:
                wrong.append(turn)
                print(f"killed at the calls {killed}:", *found, sep="\n  ", flush=True)
        killed = sum(number * count for number, count in counts.items())
        print(f"{killed} kills in {kills} blocks of {last} writing calls, {len(wrong)} wrong")
        sys.exit(1 if wrong or killed < kills // 2 else 0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 3,
         int(sys.argv[4]) if len(sys.argv) > 4 else 1)
