#!/usr/bin/env python3
"""Where does an archive of ten million photos stop scaling? A model with measured parameters.

    cluster_model.py [--photo-s 2.7] [--start-s 0.1] [--start-us-per-photo 170] [--whole-s 2.7]
                     [--photo-mb 30] [--store-gb-s 2] [--fails-per-1000-h 10]

Photos come in blocks. A block is a chain of `orient slurm`: parts of a stage, each of which first
reads the list of the whole block, then a run of the whole block on one worker. Workers take what is
ready (list scheduling); processing times of photos vary by a factor of two; all workers together
read no faster than the store sends; a worker that fails is back after ten minutes, and its part
starts again but keeps what is done. Prints, for 10, 100 and 1,000 workers and blocks of 1,000,
10,000 and 100,000 photos, how long ten million photos take and which share of the workers' time is
spent on photos.
"""

import argparse
import heapq
import random

PHOTOS = 10_000_000
PART_S = 20 * 60  # work in a part, as divided by orient slurm
MOST_PARTS = 1000
BACK_S = 600
SCATTER = 0.7  # sigma of the logarithm of a photo's time


def parts_of(block, photo_s):
    return max(1, min(MOST_PARTS, round(block * photo_s / PART_S)))


def part_seconds(photos, photo_s, draw):
    """Total time of that many photos: times are log-normal, sums of several nearly normal."""
    spread = (2.718281828 ** (SCATTER * SCATTER) - 1) ** 0.5
    return max(photo_s, draw.gauss(photos * photo_s, photo_s * spread * photos ** 0.5))


def simulate(workers, block, measured, draw):
    """Hours until all is done, and the share of the workers' time that is spent on photos."""
    # The throughput of the store limits all workers together.
    slow = max(1.0, workers * measured.photo_mb / measured.photo_s / (1000 * measured.store_gb_s))
    photo_s = measured.photo_s * slow
    start_s = measured.start_s + measured.start_us_per_photo * 1e-6 * block
    parts = parts_of(block, photo_s)
    blocks = max(1, PHOTOS // block)
    free = [0.0] * workers  # when each worker is free
    open_blocks = []  # times when the parts are done, of blocks whose run as a whole is pending
    fails_per_s = measured.fails_per_1000_h / 1000 / 3600
    own = 0.0

    def work(seconds, ready=0.0):
        """Runs work on the next free worker; returns when it is done."""
        at = max(heapq.heappop(free), ready)
        end = at + seconds
        while draw.random() < 1 - 2.718281828 ** (-fails_per_s * seconds):
            end += BACK_S + start_s + photo_s / 2
            seconds = 0
        heapq.heappush(free, end)
        return end

    for _ in range(blocks):
        done = 0.0
        for _ in range(parts):
            seconds = part_seconds(block / parts, photo_s, draw)
            own += seconds / slow
            done = max(done, work(start_s + seconds))
        heapq.heappush(open_blocks, done)
        while open_blocks and open_blocks[0] <= free[0]:
            work(start_s + block * measured.whole_s, heapq.heappop(open_blocks))
            own += block * measured.whole_s
    while open_blocks:
        work(start_s + block * measured.whole_s, heapq.heappop(open_blocks))
        own += block * measured.whole_s
    end = max(free)
    return end / 3600, own / (end * workers)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, default, what in (
            ("photo-s", 2.7, "interior and exterior orientation of a photo"),
            ("start-s", 0.1, "start of a part, before its first photo"),
            ("start-us-per-photo", 170, "additional start time for each photo of the block"),
            ("whole-s", 2.7, "time for a photo in the run of the whole block"),
            ("photo-mb", 30, "data read from the store for a photo"),
            ("store-gb-s", 2, "throughput of the store for all workers together"),
            ("fails-per-1000-h", 10, "failures of a worker in 1,000 hours")):
        parser.add_argument(f"--{name}", type=float, default=default, help=what)
    measured = parser.parse_args()
    print("| workers | photos per block | ten million take | worker time spent on photos |")
    print("|---|---|---|---|")
    for workers in (10, 100, 1000):
        for block in (1_000, 10_000, 100_000):
            hours, share = simulate(workers, block, measured, random.Random(1))
            print(f"| {workers} | {block:,} | {hours / 24:.1f} days | {100 * share:.0f} % |")


if __name__ == "__main__":
    main()
