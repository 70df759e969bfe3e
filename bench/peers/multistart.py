"""What an engineer with pinocchio + coal would write: a sequence of quadratic programs on signed distances, from many starts.

The start is the query itself, then in turns the nearest of a table of free configurations and a free configuration in a random
direction, farther and farther away; both are first pulled toward the query as far as they stay free."""
import time

import numpy as np
import pinocchio as pin
import quadprog
from scipy.spatial import cKDTree

# Pairs farther apart than this are no constraints of a step [m].
MARGIN = 0.1
# Penalty of one metre of violation: larger than the multipliers, which are in rad per m.
PENALTY = 100.0
STEPS, TRUST, LEAST_TRUST = 30, 0.3, 1e-4
TABLE = 20_000


class NearDistances:
    """Signed distances [m] of the pairs nearer than a margin, with gradients. Pairs whose bounding balls are farther apart are skipped."""

    def __init__(self, scene):
        self.scene, self.count = scene, 0
        objects = scene.geometry.geometryObjects
        for g in objects:
            g.geometry.computeLocalAABB()
        self.centres = [np.array(g.geometry.aabb_center) for g in objects]
        radii = np.array([g.geometry.aabb_radius for g in objects])
        self.pairs = np.array([(p.first, p.second) for p in scene.geometry.collisionPairs])
        self.reach = radii[self.pairs].sum(axis=1)
        self.joints = np.array(scene.parents)[self.pairs]

    def __call__(self, q, margin):
        s = self.scene
        self.count += 1
        x = s.full(q)
        pin.computeJointJacobians(s.model, s.data, x)
        pin.updateGeometryPlacements(s.model, s.data, s.geometry, s.geometry_data)
        middles = np.array([m.act(c) for m, c in zip(s.geometry_data.oMg, self.centres)])
        apart = np.linalg.norm(middles[self.pairs[:, 0]] - middles[self.pairs[:, 1]], axis=1) - self.reach
        found = [(k, pin.computeDistance(s.geometry, s.geometry_data, int(k))) for k in np.flatnonzero(apart < margin)]
        found = [(k, result) for k, result in found if result.min_distance <= margin]
        if not found:
            return np.zeros(0), np.zeros((0, len(s.joints)))
        normals = np.array([result.normal for _, result in found])
        points = np.array([[result.getNearestPoint1(), result.getNearestPoint2()] for _, result in found])
        joints = self.joints[[k for k, _ in found]]
        origins = np.array([m.translation for m in s.data.oMi])
        frame = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobians = np.zeros((s.model.njoints, 6, s.model.nv))
        for joint in set(joints.flat) - {0}:
            jacobians[joint] = pin.getJointJacobian(s.model, s.data, int(joint), frame)
        gradients = np.zeros((len(found), s.model.nv))
        for side, sign in ((0, -1.0), (1, 1.0)):
            arms = points[:, side] - origins[joints[:, side]]
            turning = arms[:, [1, 2, 0]] * normals[:, [2, 0, 1]] - arms[:, [2, 0, 1]] * normals[:, [1, 2, 0]]
            gradients += sign * np.einsum("mi,miv->mv", np.hstack([normals, turning]), jacobians[joints[:, side]])
        return np.array([result.min_distance for _, result in found]), gradients[:, s.iv]


class MultiStart:
    def __init__(self, scene, seed, starts):
        self.scene, self.rng, self.starts = scene, np.random.default_rng(seed), starts
        self.near = NearDistances(scene)
        # The table comes from checking random configurations, which counts as learning and is not timed.
        tried = (self.rng.uniform(scene.low, scene.high) for _ in range(20 * TABLE))
        found = []
        for q in tried:
            if scene.free(q):
                found.append(q)
                if len(found) == TABLE:
                    break
        self.table, self.tree = np.array(found), cKDTree(self.points(np.array(found)))

    def points(self, rows):
        """Embeds configurations for the search of the table: circles as chords."""
        circle = self.scene.circle
        return np.hstack([rows[:, ~circle], np.cos(rows[:, circle]), np.sin(rows[:, circle])])

    def solve(self, q):
        """Returns the best witness after 1, 2, 4, ... starts, each with the seconds and distance evaluations so far."""
        began, before = time.thread_time(), self.near.count
        best, length, stages, around = None, np.inf, {}, None
        for k in range(self.starts):
            if k == 1:
                _, around = self.tree.query(self.points(q[None])[0], k=self.starts // 2)
            start = q if k == 0 else self.pulled(q, self.table[around[k // 2]] if k % 2 else self.free_around(q, 3.0 * k / self.starts))
            end = None if start is None else self.descend(q, start)
            if end is not None and self.scene.distance(q, end) < length:
                best, length = end, self.scene.distance(q, end)
            if (k + 1) & k == 0:
                stages[k + 1] = {"witness": best, "seconds": time.thread_time() - began, "checks": self.near.count - before}
        return stages

    def free_around(self, q, radius):
        s = self.scene
        for _ in range(100):
            way = self.rng.normal(size=len(q))
            x = q + radius * way / np.linalg.norm(way)
            x = np.where(s.circle, x, np.clip(x, s.low, s.high))
            if s.free(x):
                return x
        return None

    def pulled(self, q, free, halvings=8):
        """Halves the segment from `free` to `q`, and returns the free end nearest to `q`."""
        if free is None:
            return None
        way, fraction, step = self.scene.delta(free, q), 0.0, 0.5
        for _ in range(halvings):
            if self.scene.free(free + (fraction + step) * way):
                fraction += step
            step /= 2
        return free + fraction * way

    def descend(self, q, x):
        s, trust, best, merit = self.scene, TRUST, None, np.inf
        target = 1.05 * s.clearance
        at = x, *self.near(x, MARGIN)
        for _ in range(STEPS):
            distances = at[1]
            violation = max(0.0, target - distances.min(initial=np.inf))
            here = 0.5 * s.distance(q, at[0]) ** 2 + PENALTY * violation
            if here < merit - 1e-10:
                merit, centre = here, at
                if violation <= 0.1 * s.clearance and (best is None or s.distance(q, at[0]) < s.distance(q, best)):
                    best = at[0]
            else:
                trust /= 2
            step = self.step(q, *centre, trust, target) if trust > LEAST_TRUST else None
            if step is None or np.abs(step).max() < 1e-6:
                break
            x = centre[0] + step
            at = x, *self.near(x, MARGIN)
        return best if best is not None and s.free(best) else None

    def step(self, q, x, distances, gradients, trust, target):
        """Minimises half the squared distance to the query plus the penalty on one slack of all linearised pairs, in a box."""
        s, n = self.scene, len(x)
        low = np.where(s.circle, -trust, np.maximum(-trust, s.low - x))
        high = np.where(s.circle, trust, np.minimum(trust, s.high - x))
        rows = np.zeros((2 * n + 1 + len(distances), n + 1))
        rows[:n, :n], rows[n:2 * n, :n], rows[2 * n, n] = np.eye(n), -np.eye(n), 1
        rows[2 * n + 1:, :n], rows[2 * n + 1:, n] = gradients, 1
        right = np.concatenate([low, -high, [0], target - distances])
        quadratic, linear = np.eye(n + 1), np.append(s.delta(x, q), -PENALTY)
        try:
            return quadprog.solve_qp(quadratic, linear, rows.T, right)[0][:n]
        except ValueError:
            # The box is empty by rounding.
            return None
