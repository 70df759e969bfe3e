#!/usr/bin/env python3
"""What Python adds to queries: figures for docs/benchmarks/python.md.

    python3 bench/python_batch.py [--queries 1000000] [--refined 2000] [--rounds 5]

Needs cargo, Python 3.9 or newer and a network: builds the release wheel and our side of the benchmarks, installs the wheel into an empty
environment (target/bench/python) and goes on there. Measured on the built-in `shelf-arm`, 7 joints.

batch    `Model.query_batch` on one thread against the same rows answered by a program in Rust (`extricate-bench batch`) with the library's
         `Model::query_batch`; beside it against a bare loop that adds up depths and keeps no answer. From the numbers to the last answer;
         learning and reading files are not counted. All sides in turns, the order changing from round to round.
threads  two threads of Python that ask one model, each its own queries one by one, against one thread; beside it the same for threads of
         Rust, which is what the machine gives.

Processor time is that of all threads of the program. Wall time says something only where nothing else runs: the share of a core that other
programs had is measured and shown.
"""
import argparse
import json
import os
import pathlib
import resource
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
    """The wheel in an environment of its own, and there once more this program."""
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
    os.execve(python, [str(python), __file__, *sys.argv[1:]], {**os.environ, PREPARED: "1"})


class Bench:
    def __init__(self, options, folder):
        import extricate

        self.options, self.folder = options, folder
        self.scene = extricate.Scene.builtin("shelf-arm")
        self.model = extricate.learn(self.scene, labels=options.labels, seed=1)
        self.model.save(folder / "arm.model")

    def batches(self):
        """Rows of what was asked and, per round, the times of both sides."""
        few, many = self.options.refined, self.options.queries
        return [
            self.batch("colliding", "nearest", many),
            self.batch("free", "refined", many),
            self.batch("colliding", "refined", few),
        ]

    def batch(self, kind, effort, count):
        Q = self.scene.sample(count, seed=7, colliding=kind == "colliding")
        file = self.folder / "queries"
        Q.tofile(file)
        rounds = []
        for k in range(self.options.rounds):
            sides = {"rust": lambda: self.rust(file, effort, 1), "loop": lambda: self.rust(file, effort, "loop"), "python": lambda: self.python(Q, effort)}
            order = [*sides, *sides][k % 3 : k % 3 + 3]
            others = Others()
            times = {side: sides[side]() for side in order}
            times["others"] = others.share()
            depths = [times[side]["depth"] for side in order]
            assert max(depths) - min(depths) <= 1e-9 * max(depths), f"the sides disagree: {depths}"
            rounds.append(times)
            print(f"{count:,} {kind}, {effort}: {times}", flush=True)
        return {"kind": kind, "effort": effort, "count": count, "rounds": rounds}

    def rust(self, file, effort, threads):
        program = ROOT / "target" / "release" / "extricate-bench"
        words = [program, "batch", self.folder / "arm.model", file, effort, str(threads)]
        return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)

    def python(self, Q, effort):
        began, processor = time.perf_counter(), time.process_time()
        answers = self.model.query_batch(Q, effort=effort, threads=1)
        times = {"wall": time.perf_counter() - began, "processor": time.process_time() - processor}
        return times | {"depth": float(answers["depth"].sum())}

    def threads(self):
        """Rows of what was asked and, per round, how many times the rate of one thread two have."""
        rows = []
        for effort, count in (("refined", self.options.refined // 8), ("nearest", self.options.refined * 5)):
            Q = self.scene.sample(2 * count, seed=8, colliding=True)
            file, rounds = self.folder / "queries", []
            Q.tofile(file)
            for _ in range(self.options.rounds):
                others = Others()
                one, two = self.asked(Q, effort, 1), self.asked(Q, effort, 2)
                rust = self.rust(file, effort, 1)["wall"] / self.rust(file, effort, 2)["wall"]
                rounds.append({"python": one / two, "rust": rust, "others": others.share()})
                print(f"threads, {effort}: {rounds[-1]}", flush=True)
            rows.append({"effort": effort, "count": len(Q), "rounds": rounds})
        return rows

    def asked(self, Q, effort, threads):
        """Wall seconds for all of Q, one query a call, parted among threads."""

        def ask(mine):
            for q in mine:
                self.model.query(q, effort=effort)

        workers = [threading.Thread(target=ask, args=(Q[k::threads],)) for k in range(threads)]
        began = time.perf_counter()
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return time.perf_counter() - began


class Others:
    """What programs other than this one and those it calls do from now on."""

    def __init__(self):
        self.began, self.before = time.perf_counter(), self.seconds()

    def seconds(self):
        ours = sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        user, nice, system = (int(word) for word in open("/proc/stat").readline().split()[1:4])
        return (user + nice + system) / os.sysconf("SC_CLK_TCK") - ours

    def share(self):
        """Of one core."""
        return max(0.0, self.seconds() - self.before) / (time.perf_counter() - self.began)


def shown(values, digits):
    return f"{statistics.median(values):{digits}} ({min(values):{digits}} to {max(values):{digits}})"


def section(batches, threads, cores):
    from page import number, table

    rows = []
    for row in batches:
        rounds = row["rounds"]
        def over(side, clock):
            return [r["python"][clock] / r[side][clock] - 1 for r in rounds]

        added = over("rust", "processor")
        each = 1e6 * statistics.median(r["rust"]["processor"] for r in rounds) / row["count"]
        met = statistics.median(added) < MOST
        text = shown(added, "+.1%")
        rows.append([f"{row['count']:,} {row['kind']}", f"`{row['effort']}`", number(each), text if met else f"**{text}**", shown(over("rust", "wall"), "+.1%"), shown(over("loop", "processor"), "+.1%"),
                     f"{statistics.median(r['others'] for r in rounds):.0%}"])
    head = ["batch", "effort", "a query in Rust [us]", "Python adds, processor time", "wall time", "over a bare loop, processor time", "other programs had, of a core"]
    text = f"{cores} cores; medians of {len(batches[0]['rounds'])} rounds, and their range. Target: less than {MOST:.0%}; misses in bold.\n\n{table(head, rows)}\n\n"
    rows = []
    for row in threads:
        gains = [r["python"] for r in row["rounds"]]
        gain = shown(gains, ".2f")
        rows.append([f"`{row['effort']}`", f"{row['count']:,}", gain if statistics.median(gains) >= LEAST_GAIN else f"**{gain}**",
                     shown([r["rust"] for r in row["rounds"]], ".2f"), f"{statistics.median(r['others'] for r in row['rounds']):.0%}"])
    head = ["effort", "queries", "two threads of Python over one", "two threads of Rust over one", "other programs had, of a core"]
    return text + f"Rates of queries asked one by one. Target: {LEAST_GAIN} times that of one thread.\n\n{table(head, rows)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--queries", type=int, default=1_000_000, help="of the large batches")
    parser.add_argument("--refined", type=int, default=2000, help="of the small one")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--labels", type=int, default=100_000)
    options = parser.parse_args()
    if PREPARED not in os.environ:
        prepare()
    from page import put

    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, pathlib.Path(folder))
        text = section(bench.batches(), bench.threads(), os.cpu_count())
    print(text)
    put(ROOT / "docs" / "benchmarks" / "python.md", "bench/python_batch.py", text, "Python, measured")


if __name__ == "__main__":
    main()
