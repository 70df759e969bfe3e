"""A dense search for free configurations that hold links, which shares no code with extricate: kinematics and inverse kinematics in
numpy over many random starts at once, from pinocchio's model; what is free is asked of the caller."""
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

# Random starts of a search; half are drawn from anywhere, half around the query.
STARTS = 2000
# The nearest free ones that are improved, the most rounds, and the candidates of each a round. One is given up once its candidates
# are this near to it [share of its distance], or if it is this many times as far as the nearest.
PARENTS, ROUNDS, CHILDREN = 12, 80, 16
LEAST_REACH, FAR = 2e-3, 1.6
# Steps of an inverse kinematics, the longest step [rad], and the damping of its normal equations.
STEPS, LONGEST, DAMPING = 25, 0.7, 1e-7


@dataclass
class Held:
    """A link that is held: a frame of pinocchio's model, in the coordinates of `base` (None: the world), at `target` (4 x 4).

    position, rotation: tolerances [m] and [rad]; None is free. axis: the rotation holds this axis of the link alone."""
    link: str
    target: np.ndarray
    base: str | None = None
    position: float | None = 1e-4
    rotation: float | None = 1e-3
    axis: tuple | None = None


class Kinematics:
    """Poses and Jacobians of many configurations at once; `scene` is a PinScene."""

    def __init__(self, scene):
        model, self.scene = scene.model, scene
        column = {int(joint.id): k for k, joint in enumerate(scene.joint(name) for name in scene.joints)}
        self.joints = []
        for j in range(1, model.njoints):
            data = model.joints[j].createData()
            model.joints[j].calc(data, np.array([1.0, 0.0]) if model.joints[j].nq == 2 else np.zeros(1))
            linear, angular = np.split(np.array(data.S).reshape(6), 2)
            turns = np.linalg.norm(angular) > 0
            self.joints.append((column[j], int(model.parents[j]), model.jointPlacements[j], angular if turns else linear, turns))

    def poses(self, Q):
        """Returns the rotations (n, 3, 3) and positions (n, 3) of every joint's frame; the first is the world's."""
        R, p = [np.broadcast_to(np.eye(3), (len(Q), 3, 3))], [np.zeros((len(Q), 3))]
        for column, parent, placement, axis, turns in self.joints:
            x = Q[:, column]
            R0, p0 = R[parent] @ placement.rotation, p[parent] + R[parent] @ placement.translation
            if turns:
                K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
                s, c = np.sin(x)[:, None, None], np.cos(x)[:, None, None]
                R.append(R0 @ (np.eye(3) + s * K + (1 - c) * (K @ K)))
                p.append(p0)
            else:
                R.append(R0)
                p.append(p0 + (R0 @ axis) * x[:, None])
        return R, p

    def frame(self, name, R, p):
        """Returns the joint that moves a frame, and its rotations and positions."""
        if name is None:
            return 0, R[0], p[0]
        frame = self.scene.model.frames[self.scene.model.getFrameId(name)]
        j = int(frame.parentJoint)
        return j, R[j] @ frame.placement.rotation, p[j] + R[j] @ frame.placement.translation

    def columns(self, joint, point, R, p, nq):
        """Returns velocities (n, 6, nq) of a point on a joint's body: translation above rotation."""
        J = np.zeros((len(point), 6, nq))
        while joint:
            column, parent, _, axis, turns = self.joints[joint - 1]
            z = R[joint] @ axis
            J[:, :3, column] = np.cross(z, point - p[joint]) if turns else z
            if turns:
                J[:, 3:, column] = z
            joint = parent
        return J

    def offsets(self, Q, held, jacobians=False):
        """Returns offsets of held links in their bases, (n, 6) each of translation and rotation, and their Jacobians."""
        R, p = self.poses(Q)
        found, rows = [], []
        for one in held:
            jl, Rl, pl = self.frame(one.link, R, p)
            jb, Rb, pb = self.frame(one.base, R, p)
            T = np.swapaxes(Rb, 1, 2)
            now, apart = T @ Rl, pl - pb
            shift = np.einsum("nij,nj->ni", T, apart) - one.target[:3, 3]
            if one.axis is None:
                turn = Rotation.from_matrix(now @ one.target[:3, :3].T).as_rotvec()
            else:
                axis = np.array(one.axis) / np.linalg.norm(one.axis)
                goal, here = one.target[:3, :3] @ axis, now @ axis
                turn = np.cross(goal, here)
                sine = np.linalg.norm(turn, axis=1)
                turn *= (np.arctan2(sine, here @ goal) / np.maximum(sine, 1e-12))[:, None]
            found.append(np.hstack([shift, turn]))
            if jacobians:
                a, b = self.columns(jl, pl, R, p, Q.shape[1]), self.columns(jb, pb, R, p, Q.shape[1])
                linear = a[:, :3] - b[:, :3] - np.swapaxes(np.cross(np.swapaxes(b[:, 3:], 1, 2), apart[:, None]), 1, 2)
                angular = a[:, 3:] - b[:, 3:]
                rows.append(np.concatenate([T @ linear, T @ angular], axis=1))
        return found, rows

    def errors(self, Q, held):
        """Returns the distances [m] and angles [rad] by which each held link is off, (n, links) each."""
        found, _ = self.offsets(Q, held)
        return tuple(np.stack([np.linalg.norm(one[:, part], axis=1) for one in found], axis=1) for part in (slice(3), slice(3, 6)))

    def within(self, Q, held, share=1.0):
        shift, turn = self.errors(Q, held)
        good = np.ones(len(Q), bool)
        for k, one in enumerate(held):
            good &= one.position is None or shift[:, k] <= share * one.position
            good &= one.rotation is None or turn[:, k] <= share * one.rotation
        return good

    def solve(self, Q, held):
        """Moves configurations to where the links are held, by damped Newton steps within the limits; returns those that get there."""
        Q, done = Q.copy(), []
        keep = np.concatenate([[one.position is not None] * 3 + [one.rotation is not None] * 3 for one in held])
        for _ in range(STEPS):
            good = self.within(Q, held, 0.9)
            done.append(Q[good])
            Q = Q[~good]
            if not len(Q):
                break
            found, rows = self.offsets(Q, held, True)
            e, J = np.hstack(found)[:, keep], np.concatenate(rows, axis=1)[:, keep]
            step = -np.einsum("nij,ni->nj", J, np.linalg.solve(J @ np.swapaxes(J, 1, 2) + DAMPING * np.eye(keep.sum()), e[..., None])[..., 0])
            longest = np.abs(step).max(axis=1, keepdims=True)
            Q = self.clip(Q + step * np.minimum(1, LONGEST / np.maximum(longest, 1e-12)))
        done.append(Q[self.within(Q, held, 0.9)])
        return np.concatenate(done)

    def clip(self, Q):
        s = self.scene
        return np.where(s.circle, Q, np.clip(Q, s.low, s.high))

    def unwound(self, Q, q):
        """Turns joints by whole turns to where they are nearest to q within their limits."""
        s = self.scene
        turns = np.array([turns for *_, turns in sorted(self.joints, key=lambda joint: joint[0])])
        other = Q - 2 * np.pi * np.round((Q - q) / (2 * np.pi))
        return np.where(turns & (s.circle | (other >= s.low) & (other <= s.high)), other, Q)


def nearest(kinematics, q, held, is_free, rng):
    """Returns the nearest free configuration to q that holds the links which a dense search finds, or None."""
    scene, n = kinematics.scene, len(q)
    low, high = np.where(scene.circle, q - np.pi, scene.low), np.where(scene.circle, q + np.pi, scene.high)
    near = q + rng.normal(size=(STARTS // 2, n)) * rng.uniform(0.05, 1.5, (STARTS // 2, 1))
    starts = np.concatenate([rng.uniform(low, high, (STARTS - STARTS // 2, n)), kinematics.clip(near)])
    found = free_of(kinematics, q, kinematics.solve(starts, held), is_free)
    if not len(found):
        return None
    best = found[:PARENTS]
    reach = np.full(len(best), 0.3)
    for _ in range(ROUNDS):
        before = np.linalg.norm(best - q, axis=1)
        active = np.flatnonzero((reach > LEAST_REACH) & (before < FAR * before.min()))
        if not len(active):
            break
        # Each child is pulled toward the query and shaken, both by at most the reach of its parent.
        parents = np.repeat(active, CHILDREN)
        size = reach[parents, None] * rng.uniform(0, 1, (len(parents), 1))
        pull = rng.uniform(0, 1, (len(parents), 1)) * size
        noise = rng.normal(size=(len(parents), n)) * rng.uniform(0, 1, (len(parents), 1)) / np.sqrt(n)
        children = best[parents] + pull * (q - best[parents]) + size * noise * before[parents, None]
        moved = free_of(kinematics, q, kinematics.solve(kinematics.clip(children), held), is_free, before[active].max())
        # A child belongs to the nearest parent, since solving loses some and the order of all.
        of = active[np.argmin(np.linalg.norm(moved[:, None] - best[active], axis=2), axis=1)] if len(moved) else np.zeros(0, int)
        for k in active:
            mine = moved[of == k]
            better = len(mine) and np.linalg.norm(mine[0] - q) < before[k]
            reach[k] = min(0.5, 1.5 * reach[k]) if better else 0.6 * reach[k]
            if better:
                best[k] = mine[0]
    return best[np.argmin(np.linalg.norm(best - q, axis=1))]


def free_of(kinematics, q, Q, is_free, most=np.inf):
    """Returns the free ones of some configurations, nearest to q first, up to a distance."""
    Q = kinematics.unwound(Q, q)
    distance = np.linalg.norm(Q - q, axis=1)
    order = np.argsort(distance)
    order = order[distance[order] < most]
    return Q[order][is_free(Q[order])] if len(order) else Q[:0]
