"""Cost of learning against degrees of freedom: planar arms of 2 to 20 joints among six posts, up to a fixed quality of queries with few checks."""
import statistics

import matplotlib.pyplot as plt
import numpy as np

import programs
import scenes
from excess import SLIGHT, asked, depths
from page import number, save, table

JOINTS = (2, 3, 4, 5, 7, 10, 14, 20)
# Checks that queries of a good model take, and 2.5 times as many. Without a limit, queries make up for a small model by a wider search.
LIMITS = (20, 50)
# Share of queries within 5 % of the best known that has to be reached.
QUALITY = 0.95
# Labels are doubled until the quality is reached, at most DOUBLINGS times. After REFERENCE doublings, an exhaustive search gives the best known.
FIRST_LABELS, DOUBLINGS, REFERENCE = 640, 13, 9


def measure(options, folder):
    rows = []
    for count in JOINTS:
        scene = arm(folder, count)
        queries = programs.sample(scene, options.queries, 23)
        model, found = folder / f"{scene.stem}.model", {}
        programs.learn(scene, model, FIRST_LABELS << REFERENCE)
        best = np.minimum(asked(model, queries, "exhaustive"), asked(model, queries))
        for labels in (FIRST_LABELS << k for k in range(DOUBLINGS)):
            learned = programs.learn(scene, model, labels, seed=1)
            full = programs.answers(model, queries)
            limited = {limit: asked(model, queries, f"{limit}-checks") for limit in LIMITS}
            found[labels] = {"cpu": learned["cpu_seconds"], "us": 1e6 * statistics.median(a["seconds"] for a in full), "depths": {None: depths(full)} | limited}
            best = np.minimum.reduce([best, *found[labels]["depths"].values()])
            shares = {limit: share(depth, best) for limit, depth in found[labels]["depths"].items()}
            print(f"{count} joints, {labels} labels: {shares}", flush=True)
            if shares[LIMITS[0]] >= QUALITY:
                break
        for row in found.values():
            row["shares"] = {limit: share(depth, best) for limit, depth in row.pop("depths").items()}
        rows.append({"joints": count, "colliding": learned["statistics"]["colliding_share"], "found": found})
    return rows


def share(depth, best):
    return float((depth <= (1 + SLIGHT) * best).mean())


def fewest(row, limit):
    """Returns the fewest labels that reach the quality, or None."""
    return next((labels for labels, found in row["found"].items() if found["shares"][limit] >= QUALITY), None)


def section(rows, folder):
    figure, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
    for limit in LIMITS:
        reached = [(row["joints"], fewest(row, limit), row) for row in rows if fewest(row, limit)]
        joints = [r[0] for r in reached]
        axes[0].semilogy(joints, [labels for _, labels, _ in reached], "o-", label=f"{limit} checks")
        axes[1].semilogy(joints, [row["found"][labels]["cpu"] for _, labels, row in reached], "o-", label=f"{limit} checks")
    for axis, name in zip(axes, ("labels", "processor seconds")):
        axis.set(xlabel="joints", ylabel=name)
        axis.grid(alpha=0.3, which="both")
        axis.legend()
    save(figure, folder / "learning-joints.svg")
    shown = []
    for row in rows:
        cells = [row["joints"], f"{row['colliding']:.0%}"]
        for limit in LIMITS:
            labels = fewest(row, limit)
            cells += [f"{labels:,}", number(row["found"][labels]["cpu"])] if labels else [f"**> {max(row['found']):,}**", ""]
        last = row["found"][fewest(row, LIMITS[0]) or max(row["found"])]
        shown.append(cells + [f"{last['shares'][None]:.3f}", number(last["us"])])
    head = ["joints", "colliding"]
    for limit in LIMITS:
        head += [f"labels, {limit} checks", "processor seconds"]
    head += ["within 5 % without a limit", "a query without a limit, median [us]"]
    return f"## Joints\n\nPlanar arms among six posts: the fewest labels ({FIRST_LABELS}, doubled) at which {QUALITY:.0%} of random colliding queries that may take {LIMITS[0]}, and " \
           f"{LIMITS[1]}, checks are answered within 5 % of the best known, and the processor time of that run, which includes what does not depend on labels. The last two columns are of the " \
           f"model of {LIMITS[0]} checks.\n\n{table(head, shown)}\n\n![Cost against joints](learning-joints.svg)"


def arm(folder, count):
    """Makes a planar chain of `count` equal links among six posts. All links are 1 m long together and bend by 8 rad together, each joint by at most 2.8."""
    length, limit = 1 / count, min(2.8, 8 / count)
    links, joints = ['<link name="link0"/>'], []
    for k in range(1, count + 1):
        size = f"{0.9 * length:.5f} 0.02 0.05"
        links.append(f'<link name="link{k}"><collision><origin xyz="{length / 2:.5f} 0 0"/><geometry><box size="{size}"/></geometry></collision></link>')
        at = 0 if k == 1 else length
        ends = f'<parent link="link{k - 1}"/><child link="link{k}"/><origin xyz="{at:.5f} 0 0"/><axis xyz="0 0 1"/>'
        joints.append(f'<joint name="joint{k}" type="revolute">{ends}<limit lower="{-limit}" upper="{limit}" effort="1" velocity="1"/></joint>')
    (folder / f"arm{count}.urdf").write_text(f'<robot name="arm">{"".join(links)}{"".join(joints)}</robot>')
    posts = [(0.62, 0.3, 0.12), (0.1, 0.75, 0.15), (-0.55, 0.35, 0.1), (-0.6, -0.45, 0.16), (0.1, -0.55, 0.1), (0.8, -0.35, 0.14)]
    text = f'clearance = 1e-4\n[[robot]]\nurdf = "arm{count}.urdf"\n'
    text += "".join(scenes.obstacle(f"post{k}", f"cylinder = [{r}, 0.4]", [x, y, 0]) for k, (x, y, r) in enumerate(posts))
    path = folder / f"arm{count}.toml"
    path.write_text(text)
    return path
