"""Our programs as the benchmarks call them."""
import json
import resource
import subprocess
from pathlib import Path

from sides import ROOT

# Where the built programs are; a benchmark may set another folder.
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
    """Colliding configurations."""
    lines = extricate("sample", scene, "-n", count, "--seed", seed, "--colliding").splitlines()
    return [json.loads(line)["q"] for line in lines]


def learn(scene, model, labels, *options, seed=1):
    """What `learn` reports, with the processor time of all its threads. Without `labels` as many as the options allow."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    budget = [] if labels is None else ["--labels", labels]
    words = ["learn", scene, "-o", model, *budget, "--seed", seed, "--json", *options]
    found = json.loads(extricate(*words).splitlines()[-1])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return found | {"cpu_seconds": after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime}


def answers(model, queries, effort="refined", *options):
    """Answers on one thread, `seconds` in processor time, of a model or of a scene without one. `effort` is a name or the number of starts of `refined`."""
    part = Path(model).with_suffix(".part")
    part.write_text("".join(json.dumps({"q": list(q)}) + "\n" for q in queries))
    return [json.loads(line) for line in run("extricate-bench", "query", model, part, effort, *options).splitlines()]
