#!/usr/bin/env python3
"""What Python adds to queries: figures for docs/benchmarks/python.md.

    python3 bench/python_batch.py [--rows 1000000] [--blocks 100] [--pairs 40] [--only batches|threads]

Needs cargo, Python 3.9 or newer and a network: builds the release wheel and our side of the benchmarks, installs the wheel into an empty
environment (target/bench/python) and goes on there. Measured on the built-in `shelf-arm`, 7 joints.

blocks   a batch in blocks, each answered by `Model.query_batch` on one thread of Python, and, just before or just after, by a program in Rust
         (`extricate-bench batch`) that asks `Solver::batch_each` for the same rows. Which is first changes from block to block: what the
         machine does meanwhile, which changes within seconds, both see alike. Beside it a bare loop in Rust that adds up
         depths and keeps no answer. From the numbers to the last answer; learning and reading files are not counted.
binding  the time that Python's side takes itself, without what is asked: rows of a scene of 7 joints and no obstacle, whose answers cost next to
         nothing, by Python and by the bare loop. What is left between them is the same for any row, and is set beside what a query takes.
whole    all rows in one call.
threads  two threads of Python that ask one model, each all queries of a block one by one, against one thread that asks them once; beside it the
         same for threads of Rust, which is what the machine gives.

A ratio is the median over blocks; in brackets the 95 % interval of the median, from the order of the blocks alone (no distribution is assumed).
Processor time is that of all threads of the program. The share of a core that other programs had is measured and shown.
"""
import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import venv

ROOT = pathlib.Path(__file__).resolve().parent.parent
HOME = ROOT / "target" / "bench" / "python"
PREPARED = "EXTRICATE_BENCH_PREPARED"
MOST, LEAST_GAIN = 0.05, 1.8


def prepare():
    """Installs the wheel into an environment of its own, and runs this program again there."""
    subprocess.run(["cargo", "build", "--release", "--quiet", "--locked", "-p", "extricate-bench"], cwd=ROOT, check=True)
    venv.create(HOME / "venv", with_pip=True, clear=True)
    python, wheels = HOME / "venv" / "bin" / "python", HOME / "wheels"
    pip = [python, "-m", "pip", "--quiet", "--disable-pip-version-check", "install"]
    subprocess.run([*pip, "maturin>=1.9.4,<2", "matplotlib"], check=True)
    manifest = ROOT / "crates" / "extricate-python" / "Cargo.toml"
    for old in wheels.glob("*.whl"):
        old.unlink()
    subprocess.run([HOME / "venv" / "bin" / "maturin", "build", "--quiet", "--locked", "--release", "--manifest-path", manifest, "--out", wheels], check=True)
    subprocess.run([*pip, *wheels.glob("*.whl")], check=True)
    enter()


def enter():
    """Restarts this program in the environment."""
    python = HOME / "venv" / "bin" / "python"
    os.execve(python, [str(python), __file__, *sys.argv[1:]], {**os.environ, PREPARED: "1"})


class Asked:
    """Rows of one model, answered by both sides alternately."""

    def __init__(self, model, Q, effort, folder):
        self.model, self.Q, self.effort = model, Q, effort
        model.save(folder / "asked.model")
        Q.tofile(folder / "queries")
        program = ROOT / "target" / "release" / "extricate-bench"
        words = [program, "batch", folder / "asked.model", folder / "queries", effort]
        self.program = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
        assert json.loads(self.program.stdout.readline()) == {"rows": len(Q)}

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        self.program.communicate()

    def rust(self, first, last, how):
        self.program.stdin.write(f"{first} {last} {how}\n")
        self.program.stdin.flush()
        return json.loads(self.program.stdout.readline())

    def python(self, first, last):
        rows = self.Q[first:last]
        began, processor = time.perf_counter(), time.process_time()
        answers = self.model.query_batch(rows, effort=self.effort, threads=1)
        times = {"wall": time.perf_counter() - began, "processor": time.process_time() - processor}
        return {**times, "depth": float(answers["depth"].sum())}

    def one_by_one(self, first, last, threads):
        """Returns wall seconds until each thread has queried all rows one by one."""
        rows = list(self.Q[first:last])

        def ask():
            for q in rows:
                self.model.query(q, effort=self.effort)

        return self.by_threads(ask, threads)

    def at_once(self, first, last, threads):
        """Returns wall seconds until each thread has queried all rows as one batch."""
        rows = self.Q[first:last]
        return self.by_threads(lambda: self.model.query_batch(rows, effort=self.effort, threads=1), threads)

    def by_threads(self, ask, threads):
        workers = [threading.Thread(target=ask) for _ in range(threads)]
        began = time.perf_counter()
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return time.perf_counter() - began

    def blocks(self, count):
        """Measures the times of all sides, block by block."""
        bounds = [len(self.Q) * k // count for k in range(count + 1)]
        sides = {"python": self.python, "rust": lambda *block: self.rust(*block, "1"), "loop": lambda *block: self.rust(*block, "loop")}
        orders = [["loop", "python", "rust"], ["rust", "python", "loop"], ["python", "rust", "loop"], ["loop", "rust", "python"]]
        found = []
        for k, block in enumerate(zip(bounds, bounds[1:])):
            others = Others()
            times = {side: sides[side](*block) for side in orders[k % 4]}
            times["others"] = others.share()
            depths = [times[side]["depth"] for side in sides]
            assert max(depths) - min(depths) <= 1e-9 * max(depths), f"the sides disagree: {depths}"
            found.append(times)
        return found


class Others:
    """Load of other programs from now on; one core is always busy with this program or its twin in Rust."""

    def __init__(self):
        self.began, self.idle = time.perf_counter(), self.idle_seconds()

    def idle_seconds(self):
        return int(open("/proc/stat").readline().split()[4]) / os.sysconf("SC_CLK_TCK")

    def share(self):
        """Returns the load as a share of one core."""
        elapsed = time.perf_counter() - self.began
        return max(0.0, (os.cpu_count() - 1) * elapsed - (self.idle_seconds() - self.idle)) / elapsed


def interval(values):
    """Returns the median and its 95 % confidence interval, from ranks by the binomial distribution."""
    ordered, n = sorted(values), len(values)
    below, rank = 0.0, 0
    while rank < n // 2 and below + math.comb(n, rank) / 2**n <= 0.025:
        below += math.comb(n, rank) / 2**n
        rank += 1
    return statistics.median(ordered), ordered[max(rank - 1, 0)], ordered[min(n - rank, n - 1)]


def shown(values, digits):
    median, low, high = interval(values)
    return f"{median:{digits}} ({low:{digits}} to {high:{digits}})"


def mark(text, met):
    return text if met else f"**{text}**"


def added(name, found, rows):
    """Makes a line of the table of blocks."""
    from page import number

    def over(side, clock):
        return [block["python"][clock] / block[side][clock] - 1 for block in found]

    each = 1e6 * sum(block["rust"]["processor"] for block in found) / rows
    # The target is met with 95 % confidence: the upper end of the interval is below it.
    met = interval(over("rust", "processor"))[2] < MOST
    others = f"{statistics.median(block['others'] for block in found):.0%}"
    return [name, len(found), number(each), mark(shown(over("rust", "processor"), "+.1%"), met), shown(over("rust", "wall"), "+.1%"),
            shown(over("loop", "processor"), "+.1%"), others]


BARE = "".join(
    f'<link name="l{k}"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>'
    f'<joint name="j{k}" type="prismatic"><parent link="rail"/><child link="l{k}"/><axis xyz="1 0 0"/><origin xyz="0 {k} 0"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    for k in range(7)
)


def batches(options, model, folder):
    """Measures what Python adds to batches, as text of the page."""
    import extricate

    from page import number, table

    arm = model.scene
    many, blocks, pairs = options.rows, options.blocks, options.pairs
    rows, whole = [], None
    for kind, effort, count, parts in [("colliding", "nearest", many, blocks), ("free", "refined", many, pairs), ("colliding", "refined", 20 * pairs, pairs)]:
        Q = arm.sample(count, seed=7, colliding=kind == "colliding")
        with Asked(model, Q, effort, folder) as asked:
            found = asked.blocks(parts)
            name = f"{count:,} {kind}, `{effort}`"
            rows.append(added(name, found, count))
            print(rows[-1], flush=True)
            if whole is None:
                nearest = sum(block["rust"]["processor"] for block in found) / count
                whole = [asked.rust(0, count, "1"), asked.python(0, count)]
                print(whole, flush=True)
    head = ["batch", "blocks", "a query in Rust [us]", "Python adds, processor time", "wall time", "over a bare loop, processor time", "other programs had, of a core"]
    text = [f"{os.cpu_count()} cores; medians over blocks and their 95 % intervals. Target: less than {MOST:.0%}; bold where the interval does not lie below it.", table(head, rows)]
    times = [f"{side[clock]:.1f}" for clock in ("processor", "wall") for side in whole]
    text.append(f"All {many:,} rows of `nearest` in one call: {times[0]} s of processor time in Rust, {times[1]} in Python; {times[2]} and {times[3]} s by the clock.")

    # Spheres that cannot collide, so that an answer costs nearly nothing.
    bare = extricate.Scene(f'<robot name="bare"><link name="rail"/>{BARE}</robot>', disable=[(f"l{a}", f"l{b}") for b in range(7) for a in range(b)])
    with Asked(extricate.learn(bare, labels=100, seed=1), bare.sample(many, seed=7), "nearest", folder) as asked:
        found = asked.blocks(pairs)
    own = [(block["python"]["processor"] - block["loop"]["processor"]) * pairs / many for block in found]
    median, low, high = interval(own)
    share = high / nearest
    text.append(f"Python's side itself, without the query: {1e9 * median:.0f} ns a row ({1e9 * low:.0f} to {1e9 * high:.0f}), "
                f"that is {mark(f'at most {share:.2%}', share < MOST)} of a `nearest` query of {number(1e6 * nearest)} us.")
    return "\n\n".join(text)


def threads(options, model, folder):
    """Measures what a second thread gains, as text of the page."""
    from page import number, table

    arm, pairs, rows = model.scene, options.pairs, []
    for effort, count in (("refined", 20), ("nearest", 4000)):
        Q = arm.sample(count * pairs, seed=8, colliding=True)
        found, others = [], []
        with Asked(model, Q, effort, folder) as asked:
            for k in range(pairs):
                block = (k * count, (k + 1) * count)
                ways = {"one": lambda: asked.one_by_one(*block, 1), "two": lambda: asked.one_by_one(*block, 2),
                        "batch of one": lambda: asked.at_once(*block, 1), "batch of two": lambda: asked.at_once(*block, 2),
                        "rust one": lambda: asked.rust(*block, "each:1")["wall"], "rust two": lambda: asked.rust(*block, "each:2")["wall"]}
                order = list(ways) if k % 2 else list(ways)[::-1]
                times = {}
                for way in order:
                    watched = Others()
                    times[way] = ways[way]()
                    others += [watched.share()] if way in ("one", "rust one") else []
                found.append((2 * times["batch of one"] / times["batch of two"], 2 * times["one"] / times["two"], 2 * times["rust one"] / times["rust two"], times["one"] / count - times["rust one"] / count))
        batch, gains, rust, more = zip(*found)
        marked = [mark(shown(way, ".2f"), interval(way)[0] >= LEAST_GAIN) for way in (batch, gains)]
        rows.append([f"`{effort}`", f"{pairs} of {count:,}", *marked, shown(rust, ".2f"),
                     number(1e6 * statistics.median(more)), f"{statistics.median(others):.0%}"])
        print(rows[-1], flush=True)
    head = ["effort", "blocks", "two threads of Python over one, a batch each", "one by one", "two threads of Rust over one", "a call costs beside the query [us]", "other programs had, of a core"]
    return f"Target: {LEAST_GAIN} times the rate of one thread; bold where the median is below. Rust asks one by one.\n\n{table(head, rows)}"


PARTS = {"batches": batches, "threads": threads}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=1_000_000, help="of the large batches")
    parser.add_argument("--blocks", type=int, default=100, help="that the large batch of `nearest` is parted into")
    parser.add_argument("--pairs", type=int, default=40, help="blocks of the others")
    parser.add_argument("--labels", type=int, default=100_000, help="that the model is learned with")
    parser.add_argument("--only", choices=PARTS, help="measure and write one part of the page")
    parser.add_argument("--built", action="store_true", help="with what the last run has built")
    options = parser.parse_args()
    if PREPARED not in os.environ:
        enter() if options.built else prepare()
    import extricate
    from page import put

    model = extricate.learn(extricate.Scene.builtin("shelf-arm"), labels=options.labels, seed=1)
    for name, part in PARTS.items():
        if options.only in (None, name):
            with tempfile.TemporaryDirectory() as folder:
                text = part(options, model, pathlib.Path(folder))
            print(text)
            put(ROOT / "docs" / "benchmarks" / "python.md", f"bench/python_batch.py, {name}", text, "Python, measured")


if __name__ == "__main__":
    main()
