"""Quality of models that were learned for few seconds on two threads."""
import numpy as np

import programs
import scenes
from excess import asked, depths, wilson, within
from page import table
from sides import others_during

SECONDS = {"panda-box": 10, "ur5-shelf": 60, "allegro-ball": 60, "panda-torus": 60}
THREADS = 2
# Labels of another model, with another seed, that only adds to the best known.
BESIDE = 1_000_000
TARGETS = {"verified": 1.0, "within_5": 0.98}


def measure(options, folder):
    rows, written = [], scenes.written()
    for name, seconds in SECONDS.items():
        scene, model, beside = written[name], folder / f"{name}-seconds.model", folder / f"{name}-beside.model"
        seconds *= options.share
        with others_during() as others:
            learned = programs.learn(scene, model, None, "--seconds", seconds, "--threads", THREADS)
        programs.learn(scene, beside, BESIDE, seed=2)
        queries = programs.sample(scene, options.queries, 23)
        given = programs.answers(model, queries)
        best = np.min([depths(given), asked(model, queries, "exhaustive"), asked(beside, queries), asked(beside, queries, "exhaustive")], axis=0)
        found = {"verified": float(np.mean([a["verified"] for a in given]))} | within(depths(given), best)
        about = {"scene": name, "asked": seconds, "wall": learned["seconds"], "labels": learned["statistics"]["labels"], "ended_by": learned["statistics"]["ended_by"]}
        rows.append(about | found | {"others": others.cores(learned["cpu_seconds"]), "queries": len(queries)})
        print(rows[-1], flush=True)
    return rows


def section(rows, _):
    shown = [[r["scene"], f"{r['asked']:g}", f"{r['wall']:.1f}", f"{r['labels']:,}", r["ended_by"], *(told(r, key) for key in ("verified", "within_5", "within_1")), f"{r['others']:.1f}"] for r in rows]
    head = ["scene", "seconds asked for", "taken", "labels", "ended by", "verified", "within 5 %", "within 1 %", "cores that others had"]
    return f"## Seconds\n\n`learn --seconds T --threads {THREADS}`, then {rows[0]['queries']} random colliding configurations, `refined`. Best known is the least depth of `refined` and `exhaustive` of that model and of another " \
           f"of {BESIDE:,} labels. Targets: verified {TARGETS['verified']:g}, within 5 % {TARGETS['within_5']:g}; misses in bold, 95 % intervals by Wilson. How many labels the seconds buy depends on what other programs " \
           f"take of the machine.\n\n{table(head, shown)}"


def told(row, key):
    low, high = wilson(row[key], row["queries"])
    text = f"{row[key]:.3f} [{low:.3f}, {high:.3f}]"
    return text if row[key] >= TARGETS.get(key, 0) else f"**{text}**"
