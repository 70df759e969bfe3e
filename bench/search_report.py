"""Table and text of bench/search.py: how often answers miss the best known."""
import json
import pathlib

import numpy as np

from excess import wilson
from page import number, table

# Depths this near to the best known count as equal to it [rad or m]: less than the clearance of 0.1 mm, and more than descents end off.
SAME = 1e-5
# Distance from the middle of its wall at which a cart is free: half the wall, half the cart and the clearance [m].
CART = 0.5 + 0.1 + 1e-4
COLUMNS = ["scene", "program", "labels", "effort", "answers", "more than 5 % off", "interval", "more than 1 % off", "checks, mean", "checks, median", "time, median [us]"]


def best_known(name, queries, depths):
    """Returns the least depth of each query; for carts, the closed form."""
    if name.startswith("carts-"):
        q = np.array([json.loads(line)["q"] for line in pathlib.Path(queries).read_text().splitlines()])
        best = np.sqrt((np.maximum(0, CART - np.abs(q)) ** 2).sum(axis=1))
        worst = (best - np.min(depths, axis=0)).max()
        if worst > 1e-6:
            raise RuntimeError(f"{name}: an answer is {worst:g} nearer than the closed form allows")
        return best
    return np.min(depths, axis=0)


def missed(depths, best, share):
    """Whether each answer is more than `share` farther than the best known."""
    return depths > np.maximum((1 + share) * best, best + SAME)


def tables(answers, queries, earlier):
    """Makes the table, one row per scene, program, number of labels and effort; the seeds of learning are pooled."""
    groups, found = {}, []
    for cell, by_effort in answers.items():
        for effort, given in by_effort.items():
            groups.setdefault((cell.name, cell.program, cell.labels, effort), []).append(given)
    best = {}
    for name, path in queries.items():
        own = [[a["depth"] for a in given] for key, several in groups.items() if key[0] == name for given in several]
        best[name] = best_known(name, path, np.array(own + earlier[name]))
    names = list(queries)
    for key in sorted(groups, key=lambda key: (names.index(key[0]), labels(key[2]), key[3] == "exhaustive", key[1])):
        several, known = groups[key], best[key[0]]
        flat = [a for given in several for a in given]
        depths = np.array([[a["depth"] for a in given] for given in several])
        checks = [a["checks"] for a in flat]
        by_5, by_1 = (float(missed(depths, known, share).mean()) for share in (0.05, 0.01))
        row = dict(zip(("scene", "program", "labels", "effort"), key), answers=len(flat), by_5=by_5, by_1=by_1)
        row |= {"verified": all(a["verified"] for a in flat), "bounds": all(a["lower_bound"] <= a["depth"] for a in flat)}
        row |= {"checks": float(np.mean(checks)), "checks_median": float(np.median(checks)), "us": 1e6 * float(np.median([a["seconds"] for a in flat]))}
        found.append(row)
    return found


def labels(word):
    order = {"none": -2, "robot": -1, "default": float("inf")}
    return order.get(word) or int(word)


def together(rows):
    """Averages all scenes with equal weight, to one row per program, number of labels and effort."""
    groups = {}
    for row in rows:
        groups.setdefault((row["program"], row["labels"], row["effort"]), []).append(row)
    means = ("by_5", "by_1", "checks", "checks_median", "us")
    return [
        {"scene": f"**mean of {len(of)}**", "program": key[0], "labels": key[1], "effort": key[2], "answers": sum(r["answers"] for r in of)}
        | {what: float(np.mean([r[what] for r in of])) for what in means}
        for key, of in groups.items()
    ]


def line(row):
    single = not row["scene"].startswith("**")
    low, high = wilson(row["by_5"], row["answers"]) if single else (0, 0)
    interval = f"{percent(low)} to {percent(high)}" if single else ""
    words = {"none": "no model", "robot": "2,000, robot alone", "default": "default"}
    count = words.get(row["labels"]) or f"{int(row['labels']):,}"
    figures = [number(row[key]) for key in ("checks", "checks_median", "us")]
    return [row["scene"], row["program"], count, row["effort"], f"{row['answers']:,}", percent(row["by_5"]), interval, percent(row["by_1"]), *figures]


def section(answers, queries, earlier, options, command):
    """Makes the text of the page."""
    rows = tables(answers, queries, earlier)
    body = table(COLUMNS, [line(row) for row in [*together(rows), *rows]])
    unverified = sum(not row["verified"] for row in rows)
    above = sum(not row["bounds"] for row in rows)
    held = "Every answer was verified and no lower bound was above its depth." if not unverified + above else \
        f"**Rows with an answer that is not verified: {unverified}; with a bound above its depth: {above}.**"
    seeds = len(options.seeds.split(","))
    alone = len(answers) == len(queries) and not all(name.startswith("carts-") for name in queries)
    # With one model only, no effort finds exits that the model lacks, so that the best known lacks them too.
    warned = " **One model of each scene: ways out that it lacks are missed by all its answers and count as none; learn with other seeds and labels.**" if alone else ""
    told = f"{options.queries} random colliding configurations of each scene; models of {seeds} seed{'s' * (seeds > 1)}. An answer is missed where it is farther than the best " \
           "known by more than the share told. Best known is the least depth that any program, model and effort found; of carts it is the closed form. " \
           "The interval is that of the share missed by more than 5 % (Wilson, 95 %), were all answers independent; seeds share their queries, so that it is rather too narrow." + warned
    return f"## Shares missed\n\n{told} Times are processor time of one thread, {options.jobs} at a time. {held}\n\n{body}\n\nMade by:\n\n    {command}"


def percent(share):
    return "0" if share < 1e-9 else f"{100 * share:.2g} %" if share < 0.995 else "100 %"
