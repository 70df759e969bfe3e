"""The differential judge: extricate beside pinocchio (kinematics) and coal (collision), on robots drawn at random.

    python bench/judge --scenes 1000 --processes 2        # needs extricate, pin and coal
    python bench/judge --first 17 --scenes 1              # scene 17 again
    python bench/judge --self-test                        # answers that were spoiled have to be noticed

Distances by pair, verdicts, witnesses, displacements and bounds of every effort, with a model and without; frames of streams; every
edge of continuous streams, escapes, plans and repairs; releases. Every fault is printed as a line of JSON; the exit status is 1 if
there is one."""
import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed

from judged import SPOILED, Judged

# Seconds between two lines of progress of a long run.
BETWEEN_LINES = 30


def judged(seed, configs, queries, labels):
    done = Judged(seed, configs, queries, labels)
    return done.counts, done.faults


def self_test():
    for spoiled, fault in SPOILED.items():
        found = {f["what"] for seed in range(8) for f in Judged(seed, 5, 1, 0, spoiled).faults}
        if fault not in found:
            sys.exit(f"a spoiled {spoiled} was not noticed, only {found}")
    print(f"all {len(SPOILED)} kinds of spoiled answers were noticed")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenes", type=int, default=100, help="scenes to draw")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--configs", type=int, default=30, help="configurations to compare, a scene")
    parser.add_argument("--queries", type=int, default=3, help="colliding configurations to query, a scene")
    parser.add_argument("--labels", type=int, default=3000, help="labels of the model of each scene; 0 for no models")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="no scene is begun after so long")
    parser.add_argument("--self-test", action="store_true")
    args = parser.parse_args()
    if args.self_test:
        return self_test()
    started, counts, faults = time.monotonic(), {}, 0
    told = started

    def summary():
        return ", ".join(f"{n} {name}" for name, n in counts.items()) + f", {faults} faults, {time.monotonic() - started:.0f} s"

    with ProcessPoolExecutor(args.processes) as pool:
        seeds = iter(range(args.first, args.first + args.scenes))
        running = set()
        while True:
            while len(running) < 2 * args.processes and time.monotonic() - started < args.seconds and (seed := next(seeds, None)) is not None:
                running.add(pool.submit(judged, seed, args.configs, args.queries, args.labels))
            if not running:
                break
            done = next(as_completed(running))
            running.remove(done)
            found, wrong = done.result()
            counts = {name: counts.get(name, 0) + n for name, n in found.items()}
            for fault in wrong:
                print(json.dumps(fault), flush=True)
            faults += len(wrong)
            if time.monotonic() - told > BETWEEN_LINES:
                told = time.monotonic()
                print(summary(), file=sys.stderr, flush=True)
    print(summary())
    if not counts.get("answers") or not counts.get("verdicts"):
        sys.exit("nothing was judged")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
