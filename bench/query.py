#!/usr/bin/env python3
"""How the time of a query grows, and what it buys: figures and plots for docs/benchmarks/query.md.

    cargo build --release
    python3 bench/query.py [--binary target/release/extricate] [--queries 200] [--model-labels 300000]
                           [--scene SCENE.toml ...] [--only samples obstacles curve]

Needs matplotlib. Three things are measured, on one thread, on the built-in `shelf-arm` (exported as files), or for the curve also on
the scenes named:

samples    median time and checks of a query against the number of boundary samples (labels from 10^4 to the largest)
obstacles  the same against the number of obstacles: the arm among 1 to 1000 boxes
curve      time against excess over the best known answer: nearest, refined from 1, 2, 4, 8, 16 samples, exhaustive

Times are of the library call, medians over the queries; on a loaded machine only their ratios within one run mean something, so the
counts of checks stand beside them.
"""
import argparse
import json
import pathlib
import random
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(*words, stdin=None):
    done = subprocess.run([str(w) for w in words], input=stdin, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: {done.stderr}")
    return done.stdout


def lines(text):
    return [json.loads(line) for line in text.splitlines() if line.strip()]


def figures(answers):
    """Medians over answers: microseconds and checks, with their 95th percentiles."""
    seconds, checks = sorted(a["seconds"] for a in answers), sorted(a["checks"] for a in answers)
    at = int(0.95 * (len(answers) - 1))
    return {
        "us": 1e6 * statistics.median(seconds),
        "us95": 1e6 * seconds[at],
        "checks": statistics.median(checks),
        "checks95": checks[at],
    }


class Bench:
    def __init__(self, args, folder):
        self.args, self.folder = args, pathlib.Path(folder)
        run(args.binary, "demo", "--scene", "shelf-arm", "--export", self.folder / "shelf-arm")
        self.arm = self.folder / "shelf-arm" / "shelf-arm.toml"

    def learn(self, scene, labels):
        model = self.folder / f"{scene.stem}-{labels}.model"
        if not model.exists():
            run(self.args.binary, "learn", scene, "-o", model, "--labels", labels, "--seed", 1)
        return model

    def queries(self, scene):
        return run(self.args.binary, "sample", scene, "-n", self.args.queries, "--seed", 7, "--colliding")

    def ask(self, model, queries, *options):
        return lines(run(self.args.binary, "query", model, "--input", "-", "--json", *options, stdin=queries))

    def samples(self):
        rows, queries = [], self.queries(self.arm)
        labels = 10_000
        while labels <= self.args.model_labels:
            model = self.learn(self.arm, labels)
            stored = lines(run(self.args.binary, "info", model, "--json"))[0]["statistics"]["boundary_samples"]
            for effort in ("nearest", "refined"):
                rows.append({"samples": stored, "effort": effort} | figures(self.ask(model, queries, "--effort", effort)))
            labels *= 3
        return rows

    def obstacles(self):
        rows = []
        robot = self.arm.read_text().split("[[obstacle]]")[0]
        for count in (1, 3, 10, 30, 100, 300, 1000):
            # The same share of the space, whatever the number: boxes in a shell around the arm's reach.
            rng, size = random.Random(count), 0.35 / count ** (1 / 3)
            text = robot
            for i in range(count):
                x, y, z = 0.0, 0.0, 0.0
                while not 0.35 < (x * x + y * y) ** 0.5 < 1.0:
                    x, y, z = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.0, 1.2)
                sides = [round(size * rng.uniform(0.5, 1.0), 4) for _ in range(3)]
                text += f'[[obstacle]]\nname = "box{i}"\nshape = {{ box = {sides} }}\npose = {{ xyz = [{x:.3f}, {y:.3f}, {z:.3f}] }}\n'
            scene = self.arm.with_name(f"boxes{count}.toml")
            scene.write_text(text)
            model, queries = self.learn(scene, 30_000), self.queries(scene)
            for effort in ("nearest", "refined"):
                rows.append({"obstacles": count, "effort": effort} | figures(self.ask(model, queries, "--effort", effort)))
        return rows

    def curve(self):
        rows = []
        for scene in [self.arm, *self.args.scene]:
            model, queries = self.learn(scene, self.args.model_labels), self.queries(scene)
            asked = {"nearest": ["--effort", "nearest"]}
            asked |= {f"k = {k}": ["--starts", k] for k in (1, 2, 4, 8, 16)}
            asked["exhaustive"] = ["--effort", "exhaustive"]
            answers = {name: self.ask(model, queries, *options) for name, options in asked.items()}
            best = [min(a["depth"] for a in each) for each in zip(*answers.values())]
            for name, found in answers.items():
                excess = sorted(a["depth"] / b for a, b in zip(found, best))
                within = lambda share: sum(e <= 1 + share for e in excess) / len(excess)
                rows.append(
                    {"scene": scene.stem, "effort": name}
                    | figures(found)
                    | {"excess": statistics.median(excess) - 1, "excess95": excess[int(0.95 * (len(excess) - 1))] - 1}
                    | {"within 5 %": within(0.05), "within 1 %": within(0.01)}
                )
        return rows


def table(rows):
    show = lambda v: f"{v:.3g}" if isinstance(v, float) and abs(v) < 100 else f"{v:.0f}" if isinstance(v, float) else str(v)
    head = list(rows[0])
    text = "| " + " | ".join(head) + " |\n" + "|---" * len(head) + "|\n"
    return text + "".join("| " + " | ".join(show(row[key]) for key in head) + " |\n" for row in rows)


def plot_growth(rows, key, path, plt):
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.5))
    for axis, what, label in zip(axes, ("us", "checks"), ("time [us]", "checks")):
        for effort in ("nearest", "refined"):
            of = [row for row in rows if row["effort"] == effort]
            axis.loglog([row[key] for row in of], [row[what] for row in of], "o-", label=effort)
        axis.set(xlabel=key, ylabel=f"median {label}")
        axis.grid(True, which="both", alpha=0.3)
    axes[0].legend()
    figure.tight_layout()
    figure.savefig(path)


def plot_curve(rows, path, plt):
    figure, axis = plt.subplots(figsize=(6, 4))
    for scene in dict.fromkeys(row["scene"] for row in rows):
        of = [row for row in rows if row["scene"] == scene]
        axis.loglog([row["us"] for row in of], [max(1e-4, row["excess95"]) for row in of], "o-", label=scene)
        for row in of:
            axis.annotate(row["effort"], (row["us"], max(1e-4, row["excess95"])), fontsize=7)
    axis.set(xlabel="median time [us]", ylabel="excess over the best known, 95th percentile (at least 1e-4)")
    axis.grid(True, which="both", alpha=0.3)
    axis.legend()
    figure.tight_layout()
    figure.savefig(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=pathlib.Path, default=ROOT / "target/release/extricate")
    parser.add_argument("--queries", type=int, default=200)
    parser.add_argument("--model-labels", type=int, default=300_000)
    parser.add_argument("--scene", type=pathlib.Path, action="append", default=[])
    parser.add_argument("--only", nargs="+", choices=("samples", "obstacles", "curve"), default=("samples", "obstacles", "curve"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "docs/benchmarks")
    args = parser.parse_args()
    import matplotlib

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    args.out.mkdir(parents=True, exist_ok=True)
    text = "# The query in figures\n\nWritten by `bench/query.py`; what is measured stands at its head.\n"
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(args, folder)
        if "samples" in args.only:
            rows = bench.samples()
            plot_growth(rows, "samples", args.out / "query-samples.svg", plt)
            text += f"\n## Time against samples\n\n{table(rows)}\n![time against samples](query-samples.svg)\n"
        if "obstacles" in args.only:
            rows = bench.obstacles()
            plot_growth(rows, "obstacles", args.out / "query-obstacles.svg", plt)
            text += f"\n## Time against obstacles\n\n{table(rows)}\n![time against obstacles](query-obstacles.svg)\n"
        if "curve" in args.only:
            rows = bench.curve()
            plot_curve(rows, args.out / "query-curve.svg", plt)
            text += f"\n## Time against excess\n\n{table(rows)}\n![time against excess](query-curve.svg)\n"
    (args.out / "query.md").write_text(text)


main()
