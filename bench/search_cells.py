"""Scenes, queries and answers of bench/search.py, each made once and kept in a cache by what it depends on."""
import dataclasses
import functools
import hashlib
import json
import pathlib
import re
import subprocess

import programs
import scenes as named

BUILT_IN = ("planar-arm", "shelf-arm", "free-box", "dual-arm", "hand", "four-legs")


# Words in place of a number of labels: no model, or a model of the robots alone with few labels.
NO_MODEL, ROBOT_ALONE, LABELS_ALONE = "none", "robot", 2000


@dataclasses.dataclass(frozen=True)
class Cell:
    """A model and its queries."""
    name: str
    scene: pathlib.Path
    queries: pathlib.Path
    program: str
    folder: pathlib.Path
    labels: str
    seed: int


def scenes(folder, draws, robots):
    """Returns the file of every scene by name: built-in, of bench/scenes.py, and drawn."""
    found = {name: named.built_in(name) for name in BUILT_IN}
    if robots:
        found |= named.written()
    for draw in draws:
        into = folder / f"{draw}-{programs_key(pathlib.Path(programs.folder))}{'-robots' if robots else ''}"
        told = into / "scenes.jsonl"
        if not told.exists():
            text = programs.run("extricate-bench", "draw", into, draw, *(["--robots", robots] if robots else []))
            write(told, text)
        names = [json.loads(line)["scene"] for line in told.read_text().splitlines()]
        found |= {pathlib.Path(name).stem: into / name for name in names}
    return found


def queries(cache, scene, count, seed):
    """Returns a file of random colliding configurations."""
    path = cache / "queries" / f"{scene.stem}-{key(scene_key(scene), count, seed)}.jsonl"
    if not path.exists():
        write(path, "".join(json.dumps({"q": q}) + "\n" for q in programs.sample(scene, count, seed)))
    return path


def answers(cache, cell, efforts, keep):
    """Returns answers by effort; learns the model if an answer is missing."""
    model_key = key(scene_key(cell.scene), programs_key(cell.folder), cell.labels, cell.seed)
    model = cache / "models" / f"{cell.name}-{model_key}.model"
    asked = file_key(cell.queries)
    paths = {effort: answers_folder(cache, cell.queries) / f"{key(model_key, asked, effort)}.jsonl" for effort in efforts}
    for effort, path in paths.items():
        if path.exists():
            continue
        if cell.labels == NO_MODEL:
            write(path, run(cell.folder, "extricate-bench", "query", cell.scene, cell.queries, effort))
            continue
        if not model.exists():
            learn(cell, model)
        elsewhere = ["--scene", cell.scene] if cell.labels == ROBOT_ALONE else []
        write(path, run(cell.folder, "extricate-bench", "query", model, cell.queries, effort, *elsewhere))
    if not keep:
        model.unlink(missing_ok=True)
    return {effort: rows(path) for effort, path in paths.items()}


def earlier(cache, asked):
    """Returns the depths of all cached answers to the queries of each scene, from any program."""
    found = {}
    for name, path in asked.items():
        files = sorted(answers_folder(cache, path).glob("*.jsonl"))
        found[name] = [[answer["depth"] for answer in rows(file)] for file in files]
    return found


def answers_folder(cache, asked):
    return cache / "answers" / f"{asked.stem}-{file_key(asked)}"


def learn(cell, model):
    model.parent.mkdir(parents=True, exist_ok=True)
    part = model.with_suffix(".unfinished")
    count = LABELS_ALONE if cell.labels == ROBOT_ALONE else cell.labels
    budget = [] if count == "default" else ["--labels", count]
    scene = alone(cell.scene) if cell.labels == ROBOT_ALONE else cell.scene
    run(cell.folder, "extricate", "learn", scene, "-o", part, *budget, "--seed", cell.seed, "--threads", 1)
    part.rename(model)


def alone(scene):
    """Writes the robots of a scene without its obstacles, beside it, so that paths stay valid."""
    path = scene.with_name(f"{scene.stem}-alone.toml")
    path.write_text(re.sub(r"(?ms)^\[\[obstacle\]\].*?(?=^\[|\Z)", "", scene.read_text()))
    return path


def run(folder, program, *words):
    """Does what `programs.run` does, with a program of any folder."""
    done = subprocess.run([str(folder / program), *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{folder / program} {' '.join(map(str, words))}: {done.stderr.strip()}")
    return done.stdout


def rows(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def write(path, text):
    """Writes a file and renames it at the end, so that an existing file is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_text(text)
    part.rename(path)


def scene_key(scene):
    """Hashes the scene file and the robots and meshes beside it; fetched robots count by their paths."""
    text = scene.read_text()
    words = [text]
    for path in re.findall(r'(?:urdf|mesh) = "([^"]+)"', text):
        file = scene.parent / path
        beside = sorted(file.parent.rglob("*.stl")) if path.endswith(".urdf") and not pathlib.Path(path).is_absolute() else []
        words += [file_key(one) for one in [file, *beside]]
    return key(*words)


@functools.lru_cache(maxsize=None)
def programs_key(folder):
    return key(*(file_key(folder / name) for name in ("extricate", "extricate-bench")))


def file_key(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def key(*words):
    return hashlib.sha256("\n".join(map(str, words)).encode()).hexdigest()[:16]
