"""How well few labels classify: held-out accuracy of models of `panda-box`."""
import statistics

import programs
import scenes
from excess import interval_of_mean
from page import table

LABELS, SEEDS, TARGET = 20_000, range(1, 11), 0.97
SIDES = ("free", "colliding")


def measure(options, folder):
    scene, rows = scenes.written()["panda-box"], []
    for seed in SEEDS:
        found = programs.learn(scene, folder / "accuracy.model", LABELS, seed=seed)["statistics"]
        rows.append({"seed": seed} | {side: (found[f"accuracy_{side}"], found[f"accuracy_{side}_interval"]) for side in SIDES})
        print(rows[-1], flush=True)
    return rows


def section(rows, _):
    shown, all_balanced = [], []
    for row in rows:
        shares, intervals = zip(*(row[side] for side in SIDES))
        balanced = statistics.mean(shares)
        all_balanced.append(balanced)
        show = told(balanced, interval_of_mean(shares, intervals))
        shown.append([row["seed"], *(told(*row[side]) for side in SIDES), show if balanced >= TARGET else f"**{show}**"])
    every = [row[side] for row in rows for side in SIDES]
    mean = told(statistics.mean(all_balanced), interval_of_mean(*zip(*every)))
    missed = sum(b < TARGET for b in all_balanced) or "none"
    head = ["seed", "of the free", "of the colliding", "balanced"]
    return f"## Accuracy of few labels\n\n`panda-box`, {LABELS:,} labels: shares of held-out configurations that the classifier calls what they are, with Wilson's 95 % intervals; balanced is " \
           f"the mean of both, its interval from theirs. Mean over {len(rows)} seeds: {mean}, least {min(all_balanced):.4f}; target {TARGET}, missed by {missed}.\n\n{table(head, shown)}"


def told(share, interval):
    return f"{share:.4f} [{interval[0]:.3f}, {interval[1]:.3f}]"
