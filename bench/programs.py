"""Calls of our programs by the benchmarks."""
import json
import resource
import subprocess
from pathlib import Path

from sides import ROOT

# Folder of the built programs; a benchmark may set another one.
folder = ROOT / "target" / "release"


def build():
    packages = ["-p", "extricate-cli", "-p", "extricate-bench"]
    subprocess.run(["cargo", "build", "--release", "--quiet", *packages], cwd=ROOT, check=True)


def run(program, *words):
    done = subprocess.run([str(Path(folder) / program), *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{program} {' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def extricate(*words):
    return run("extricate", *words)


def sample(scene, count, seed):
    """Draws colliding configurations."""
    lines = extricate("sample", scene, "-n", count, "--seed", seed, "--colliding").splitlines()
    return [json.loads(line)["q"] for line in lines]


def learn(scene, model, labels, *options, seed=1):
    """Learns a model; returns the report of `learn` with the processor time of all its threads. Without `labels` the options decide."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    budget = [] if labels is None else ["--labels", labels]
    words = ["learn", scene, "-o", model, *budget, "--seed", seed, "--json", *options]
    found = json.loads(extricate(*words).splitlines()[-1])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return found | {"cpu_seconds": after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime}


def answers(model, queries, effort="refined", *options):
    """Answers queries on one thread, with a model or a scene; `seconds` is processor time. `effort` is a name or the number of starts of `refined`."""
    part = Path(model).with_suffix(".part")
    part.write_text("".join(json.dumps({"q": list(q)}) + "\n" for q in queries))
    return [json.loads(line) for line in run("extricate-bench", "query", model, part, effort, *options).splitlines()]
