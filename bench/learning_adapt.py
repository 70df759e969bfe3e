"""What adapting a model to a changed scene saves, and what it misses, beside learning the changed scene anew."""
import re

import numpy as np

import programs
import scenes
from excess import asked, depths, within
from page import number, table

# Scene: the obstacle that is moved or removed, how far it moves, and where a small box is added [m].
CHANGES = {
    "planar-arm": ("cylinder_1", (0.03, 0, 0), scenes.obstacle("added", "box = [0.1, 0.1, 0.4]", [-0.25, 0.6, 0])),
    "shelf-arm": ("board_middle", (0, 0, 0.03), scenes.obstacle("added", "box = [0.1, 0.1, 0.1]", [0.4, -0.2, 0.6])),
    "panda-box": ("box", (0.03, 0, 0), scenes.obstacle("added", "box = [0.1, 0.1, 0.3]", [0.1, 0.5, 0.5])),
    "ur5-shelf": ("board_1", (0, 0, 0.03), scenes.obstacle("added", "box = [0.12, 0.12, 0.12]", [0.2, -0.4, 0.3])),
}
# There and back.
CHAINED = 4


def measure(options, folder):
    rows, written = [], scenes.written()
    for name in CHANGES:
        scene, first = written[name], folder / f"{name}.model"
        learned = programs.learn(scene, first, options.adapt_labels)["statistics"]
        for change, changed in changed_scenes(name, scene).items():
            adapted, anew = folder / f"{name}-adapted.model", folder / f"{name}-{change}.model"
            spent = [programs.adapt(first, changed, adapted)["statistics"], programs.learn(changed, anew, options.adapt_labels)["statistics"]]
            rows.append({"scene": name, "change": change} | compared(options, changed, (adapted, anew), spent))
            print(rows[-1], flush=True)
        moved, at, labels = changed_scenes(name, scene)["moved"], first, 0
        for k in range(2 * CHAINED):
            after = folder / f"{name}-chained-{k % 2}.model"
            spent = programs.adapt(at, scene if k % 2 else moved, after)["statistics"]
            at, labels = after, labels + spent["labels"]
        row = compared(options, scene, (at, first), (spent | {"labels": labels}, learned))
        rows.append({"scene": name, "change": f"moved and back, {CHAINED} times"} | row)
        print(rows[-1], flush=True)
    return rows


def changed_scenes(name, scene):
    """The scene with an obstacle moved, without it, and with one more, as files beside it."""
    obstacle, by, added = CHANGES[name]
    text = scene.read_text()
    head, *entries = text.split("[[obstacle]]")
    at = next(k for k, entry in enumerate(entries) if f'name = "{obstacle}"' in entry)
    place = lambda found: f"xyz = {[float(x) + d for x, d in zip(found[1].split(','), by)]}"
    moved, count = re.subn(r"xyz = \[(.*?)\]", place, entries[at])
    assert count == 1, entries[at]
    texts = {
        "moved": "[[obstacle]]".join([head, *entries[:at], moved, *entries[at + 1 :]]),
        "removed": "[[obstacle]]".join([head, *entries[:at], *entries[at + 1 :]]),
        "added": f"{text.rstrip()}\n{added}",
    }
    found = {change: scene.with_name(f"{name}-{change}.toml") for change in texts}
    for change, path in found.items():
        path.write_text(texts[change])
    return found


def compared(options, scene, models, spent):
    """Figures of the adapted model and of the one that was learned anew, in this order."""
    queries = programs.sample(scene, options.queries, 23)
    given = [programs.answers(model, queries) for model in models]
    best = np.min([depths(g) for g in given] + [asked(model, queries, "exhaustive") for model in models], axis=0)
    found = [within(depths(g), best) | {"checks": float(np.median([a["checks"] for a in g])), "starts": s["starts_per_dof"]["stored"], "labels": s["labels"]} for g, s in zip(given, spent)]
    return {key: [f[key] for f in found] for key in found[0]} | {"queries": len(queries)}


def section(rows, _):
    both = lambda row, key, show: " / ".join(show(x) for x in row[key])
    share = lambda x: f"{x:.3f}"
    shown = [[r["scene"], r["change"], both(r, "labels", lambda x: f"{x:,}"), both(r, "within_5", share), both(r, "within_1", share), both(r, "checks", number), both(r, "starts", number)] for r in rows]
    head = ["scene", "an obstacle", "labels", "within 5 %", "within 1 %", "checks, median", "stored starts a degree"]
    return f"## Adapting\n\nAn obstacle was moved by 3 cm, removed, or added (a small box). Cells: a model of the scene before, adapted with as many labels as `adapt` takes by itself / one learned anew. In the last row of a scene the obstacle " \
           f"was moved and put back {CHAINED} times, each model adapted from the one before; labels are those of all adaptations together, beside the model that they began with. {rows[0]['queries']} random colliding configurations of the changed " \
           f"scene, `refined`; best known is the least depth of `refined` and `exhaustive` of both.\n\n{table(head, shown)}"
