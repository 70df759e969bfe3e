#!/usr/bin/env python3
"""How learning of many scenes scales over cores, for docs/how-to/fleets.md.

    python3 bench/fleet.py [--scenes 12] [--labels 20000] [--workers 2] [--rounds 3]

Needs the installed package. Each round learns the same scenes, grippers among boxes of different sizes, into empty folders: one at a
time, then several at once. Beside it stands what the computer itself gives: the same plain arithmetic in one process, then in several.
On a busy computer neither is what it would be alone. Processor time says more there: what the program that hands out the scenes takes is
not shared between cores, what its workers take is.
"""
import argparse
import multiprocessing
import pathlib
import resource
import statistics
import tempfile
import time

import extricate
from extricate import fleet

GRIPPER = """<robot name="gripper"><link name="palm"><collision><geometry><box size="0.08 0.16 0.03"/></geometry></collision></link>
<link name="finger"><collision><origin xyz="0 0 0.04"/><geometry><box size="0.02 0.015 0.08"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="palm"/><child link="finger"/><axis xyz="0 1 0"/>
<limit lower="0.01" upper="0.06" effort="1" velocity="1"/></joint></robot>"""


def scenes(count):
    robot = extricate.Robot(GRIPPER, base="planar", bounds=((-0.3, -0.3), (0.3, 0.3)))
    return {f"box{k}": extricate.Scene(robot, [extricate.Box([0.03 + 0.01 * k, 0.05, 0.1], name="box")]) for k in range(count)}


def learned(given, labels, workers):
    """Learns scenes; returns wall seconds, and the processor seconds of this program and of its workers."""
    with tempfile.TemporaryDirectory() as folder:
        busy = [processor_seconds(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        began = time.perf_counter()
        done = list(fleet.learn(given, pathlib.Path(folder), labels=labels, seed=1, workers=workers))
        taken = time.perf_counter() - began
        own, theirs = (processor_seconds(who) - before for who, before in zip((resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN), busy))
    assert all(result.error is None and not result.cached for result in done)
    return taken, own, theirs


def processor_seconds(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def spin(_):
    total = 0
    for k in range(4_000_000):
        total += k * k % 7
    return total


def spun(count, workers):
    with multiprocessing.Pool(workers) as pool:
        pool.map(spin, range(workers))
        began = time.perf_counter()
        pool.map(spin, range(count), chunksize=1)
        return time.perf_counter() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=12)
    parser.add_argument("--labels", type=int, default=20_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    robots, ratios = scenes(given.scenes), []
    for number in range(given.rounds):
        (one, *_), (many, own, theirs) = learned(robots, given.labels, 1), learned(robots, given.labels, given.workers)
        plain = spun(given.scenes, 1) / spun(given.scenes, given.workers)
        # The time of this program is not shared by cores; that of the workers is shared evenly.
        free = (own + theirs) / (own + theirs / given.workers)
        ratios.append((one / many, plain, free))
        print(f"round {number + 1}: {one:.1f} s one at a time, {many:.1f} s with {given.workers} at once: {one / many:.2f} times; "
              f"plain arithmetic {plain:.2f} times; processor time {own:.2f} s to hand out, {theirs:.2f} s of workers: {free:.2f} times on free cores", flush=True)
    clock, plain, free = (statistics.median(column) for column in zip(*ratios))
    print(f"median: {clock:.2f} times with {given.workers} workers, plain arithmetic {plain:.2f} times; by processor time {free:.2f} times on free cores")


if __name__ == "__main__":
    main()
