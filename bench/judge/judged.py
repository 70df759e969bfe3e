"""Judges one drawn scene: distances by pair, verdicts, and answers of every effort."""
import dataclasses
import tempfile
import warnings

import numpy as np

import extricate

from drawn import draw, write
from oracle import TOLERANCE, Oracle

# Distances that differ by more than TOLERANCE plus this share of them are a fault.
RELATIVE = 1e-5
# Draws after which a scene that never or always collides is given up.
MOST_DRAWS = 60
# Configurations drawn within the bound of every query.
WITHIN = 12
# Configurations checked per edge of a path, and frames per stream.
ALONG = 8
FRAMES = 6
# Budget of a path.
MOTION = {"max_checks": 2000}
# Budgets of queries, so that one scene does not take minutes.
EFFORTS = {"nearest": {}, "refined": {}, "exhaustive": {"max_checks": 3000}, "proved": {"max_checks": 3000}}


# Spoiled answers and distances for the self-test, with the fault that the judge has to find for each.
SPOILED = {
    "distance": "distance",
    "witness": "witness collides",
    "depth": "depth",
    "bound": "bound above the best known",
    "colliding": "colliding pairs",
    "displacement": "displacement",
    "path": "edge collides",
}


# Warnings about scenes that are never free are expected here.
warnings.simplefilter("ignore")


class Judged:
    def __init__(self, seed, configs, queries, labels, spoiled=None):
        self.spoiled = spoiled
        self.faults, self.counts = [], dict.fromkeys(["scenes", "distances", "verdicts", "near contact", "answers", "bounds above 0", "within bounds", "frames", "edges", "releases"], 0)
        self.seed = seed
        drawn = draw(seed)
        rng = np.random.default_rng([seed, 1])
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.scene = extricate.Scene.load(write(drawn, folder))
        if self.scene.nq == 0:
            return
        self.drawn, self.oracle = drawn, Oracle(drawn, self.scene.joints)
        own = sorted(tuple(sorted((self.oracle.names[a], self.oracle.names[b]))) for a, b in self.oracle.pairs)
        theirs = sorted(tuple(sorted(pair)) for pair in self.scene.pairs)
        if own != theirs:
            return self.fault("pairs", expected=own, got=theirs)
        if not own:
            return
        self.counts["scenes"] = 1
        order = {tuple(sorted(pair)): k for k, pair in enumerate(self.scene.pairs)}
        self.order = [order[tuple(sorted((self.oracle.names[a], self.oracle.names[b])))] for a, b in self.oracle.pairs]
        colliding = self.compare(configs, rng)
        views = [self.scene]
        if labels and colliding:
            try:
                views.append(extricate.learn(self.scene, labels=labels, seed=seed))
            except (ValueError, RuntimeError) as error:
                # If nothing is free, nothing can be learned.
                if "free" not in str(error):
                    raise
        for q in colliding[:queries]:
            self.query(q, views, rng)
        for q in colliding[:1]:
            for view in views:
                self.streams(q, view, rng)
                self.motions(q, view, rng)
            self.release(q)

    def fault(self, what, **more):
        self.faults.append({"seed": self.seed, "what": what, **{k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in more.items()}})

    def compare(self, configs, rng):
        """Compares distances and verdicts of random configurations; returns those that certainly collide."""
        s, clearance = self.drawn.scale, self.drawn.clearance
        colliding = []
        for number in range(max(configs, MOST_DRAWS)):
            if number >= configs and colliding:
                break
            q = self.oracle.draw(rng)
            own = self.oracle.distances(q)
            theirs = self.scene.pair_distances(q)[self.order] / s + (1e-3 if self.spoiled == "distance" else 0.0)
            off = np.abs(np.maximum(own, 0) - np.maximum(theirs, 0)) > TOLERANCE + RELATIVE * np.abs(own)
            self.counts["distances"] += len(own)
            for k in np.flatnonzero(off):
                pair = [self.oracle.names[n] for n in self.oracle.pairs[k]]
                self.fault("distance", q=q, pair=pair, expected=float(own[k]), got=float(theirs[k]), scale=s)
            margin = own.min() - clearance
            if abs(margin) < 2 * TOLERANCE:
                self.counts["near contact"] += 1
                continue
            self.counts["verdicts"] += 1
            free = bool(self.scene.check(q))
            if free != (margin > 0):
                self.fault("verdict", q=q, expected=margin > 0, got=free)
            if margin < 0:
                colliding.append(q)
        return colliding

    def query(self, q, views, rng):
        self.spoiled_witness = q
        best, bounds = np.inf, []
        for view in views:
            for effort, options in EFFORTS.items():
                if effort == "nearest" and view is self.scene:
                    continue
                answer = view.query(q, effort=effort, contacts=True, **options)
                if answer is None:
                    continue
                answer = self.spoil(answer)
                self.counts["answers"] += 1
                if not self.judge(q, answer, effort, rng):
                    continue
                best = min(best, answer.depth)
                bounds.append((answer.lower_bound, effort))
        bound, effort = max(bounds, default=(0.0, ""))
        self.counts["bounds above 0"] += bound > 0
        if bound > best * (1 + 1e-9):
            self.fault("bound above the best known", q=q, effort=effort, bound=bound, best=best)
        self.draw_within(q, bound, effort, rng)

    def spoil(self, answer):
        changes = {
            "witness": {"witness": self.spoiled_witness},
            "depth": {"depth": 1.2 * answer.depth},
            "bound": {"lower_bound": 1.1 * answer.depth},
            "colliding": {"colliding": []},
            "displacement": {"max_displacement": 0.5 * answer.max_displacement},
        }
        return dataclasses.replace(answer, **changes.get(self.spoiled, {}))

    def judge(self, q, answer, effort, rng):
        """Whether the witness and the rest of an answer are right."""
        faults = len(self.faults)
        said = dict(q=q, effort=effort, witness=answer.witness, depth=answer.depth)
        low, high = self.oracle.limits()
        # With effort `nearest`, the witness was verified when the model was learned.
        if not answer.verified and effort != "nearest":
            self.fault("not verified", **said)
        if (answer.witness < low - 1e-9 * (1 + np.abs(low))).any() or (answer.witness > high + 1e-9 * (1 + np.abs(high))).any():
            self.fault("witness outside limits", **said)
        least = float(self.oracle.distances(answer.witness).min())
        if least < min(answer.clearance / self.drawn.scale, self.drawn.clearance) - TOLERANCE - (self.drawn.clearance == 0) * TOLERANCE:
            self.fault("witness collides", least=least, **said)
        if self.drawn.metric == "joint":
            distance = self.oracle.distance(q, answer.witness)
            # A small rotation angle is exact only to the square root of the rounding error.
            if abs(distance - answer.depth) > 1e-6 * max(1.0, distance):
                self.fault("depth", expected=distance, **said)
        elif self.drawn.metric == "max-displacement":
            least = self.oracle.least_displacement(q, answer.witness, rng)
            if not least * (1 - 1e-9) <= answer.depth <= 1.1 * least + 1e-9 * self.drawn.scale:
                self.fault("depth", expected=least, **said)
        # No sampled point moves farther than reported; in the metric `max-displacement`, the reported value is the depth.
        moved = self.oracle.least_displacement(q, answer.witness, rng)
        is_depth = self.drawn.metric != "max-displacement" or abs(answer.max_displacement - answer.depth) <= 1e-6 * self.drawn.scale
        if answer.max_displacement < moved * (1 - 1e-6) - 1e-9 * self.drawn.scale or not is_depth:
            self.fault("displacement", told=answer.max_displacement, expected=moved, **said)
        own = self.oracle.distances(q) - self.drawn.clearance
        pairs = [frozenset(self.oracle.names[n] for n in pair) for pair in self.oracle.pairs]
        told = {frozenset(pair) for pair in answer.colliding}
        surely = {pair for pair, d in zip(pairs, own) if d < -TOLERANCE}
        perhaps = {pair for pair, d in zip(pairs, own) if d < TOLERANCE}
        if not surely <= told <= perhaps:
            self.fault("colliding pairs", expected=sorted(map(sorted, surely)), got=sorted(map(sorted, told)), **said)
        return len(self.faults) == faults

    def streams(self, q, view, rng):
        """Judges streams toward a random configuration: every answer, and every move of a continuous stream."""
        goal = self.oracle.draw(rng)
        for continuous in (False, True):
            stream, last = view.stream(continuous=continuous), None
            for frame in range(FRAMES):
                here = self.oracle.between(q, goal, 0.02 * frame)
                answer = stream.query(here)
                if answer is None:
                    continue
                self.counts["frames"] += 1
                self.judge(here, answer, "continuous" if continuous else "stream", rng)
                if continuous and last is not None:
                    self.edge(last, answer.witness, set(), "continuous")
                last = answer.witness

    def motions(self, q, view, rng):
        """Judges every edge of an escape, a plan and a repair."""
        escape = view.escape(q, tree_checks=500, **MOTION)
        if escape.points is not None:
            points = self.spoil_path(escape.points, q)
            may_collide = {frozenset(pair) for pair, _ in escape.colliding}
            for k, (a, b) in enumerate(zip(points, points[1:])):
                self.edge(a, b, may_collide if k < escape.free_from else set(), "escape")
        ends = [answer.witness for answer in (view.query(p) for p in (q, self.oracle.draw(rng))) if answer is not None and answer.verified]
        if len(ends) < 2 or not all(self.scene.check(end) for end in ends):
            return
        plan = view.plan(*ends, **MOTION)
        repaired = view.repair(np.array([ends[0], q, ends[1]]), **MOTION)
        for path, how in ((plan, "plan"), (repaired, "repair")):
            if path.points is None:
                continue
            points = self.spoil_path(path.points, q)
            for a, b in zip(points, points[1:]):
                self.edge(a, b, set(), how)

    def spoil_path(self, points, q):
        return [points[0], q, points[-1]] if self.spoiled == "path" else points

    def edge(self, a, b, may_collide, how):
        """Checks that only pairs in `may_collide` collide along an edge."""
        self.counts["edges"] += 1
        for k in range(ALONG + 1):
            p = self.oracle.between(a, b, k / ALONG)
            least = self.oracle.distances(p) - self.drawn.clearance
            for pair in np.flatnonzero(least < -TOLERANCE * (1 + (self.drawn.clearance == 0))):
                names = [self.oracle.names[n] for n in self.oracle.pairs[pair]]
                if frozenset(names) not in may_collide:
                    return self.fault("edge collides", how=how, a=np.asarray(a), b=np.asarray(b), at=k / ALONG, pair=names, least=float(least[pair]))

    def release(self, q):
        """Checks that nothing penetrates after the release of an obstacle."""
        for name in (self.oracle.names[k] for k in range(len(self.oracle.seat), len(self.oracle.names))):
            try:
                grasp = self.scene.release(q, object=name, **MOTION)
            except ValueError:
                # No link can touch this obstacle.
                continue
            if grasp is None:
                continue
            self.counts["releases"] += 1
            least = float(self.oracle.distances(grasp.config).min())
            if not grasp.verified or least < self.drawn.clearance - TOLERANCE * (1 + (self.drawn.clearance == 0)):
                self.fault("release collides", q=q, object=name, config=grasp.config, least=least)

    def draw_within(self, q, bound, effort, rng):
        """Checks that random configurations within the bound are not free."""
        if bound == 0 or self.drawn.metric == "object-norm":
            return
        length = bound
        for _ in range(WITHIN):
            there = self.oracle.near(q, length * rng.uniform(0.3, 1.0), rng)
            if self.drawn.metric == "joint":
                distance = self.oracle.distance(q, there)
            else:
                distance = 1.1 * self.oracle.least_displacement(q, there, rng)
                length *= 0.9 * bound / max(distance, 1e-300) if distance > bound else 1.0
            if not 0 < distance < bound * (1 - 1e-6):
                continue
            self.counts["within bounds"] += 1
            if self.oracle.distances(there).min() > self.drawn.clearance + TOLERANCE:
                self.fault("free within the bound", q=q, effort=effort, bound=bound, free=there, distance=distance)
