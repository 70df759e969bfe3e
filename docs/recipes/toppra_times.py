"""Gives a planned path times by TOPP-RA, and keeps its proof.

Splines through the points of a path, the usual way, leave its edges, and what was proved of them is lost. Here each corner is
rounded by a parabola, and the parabola is proved too. Guaranteed of the timed motion, at every instant and not at samples:

- every pair of bodies keeps at least half of the scene's clearance,
- every joint keeps its limits of velocity and of acceleration.

It is for arms of revolute joints with limits: edges are then straight in the joints' coordinates. The times are those of TOPP-RA
(Pham and Pham, IEEE T-RO 2018, doi:10.1109/TRO.2018.2819195). It is `toppra` here and not `ruckig`, because Ruckig goes from state to
state and follows no given curve.
"""

import numpy as np
import toppra
from scipy.interpolate import make_interp_spline
from toppra.parametrizer import ParametrizeConstAccel

import extricate


class Curve(toppra.interpolator.AbstractGeometricPath):
    """The polyline through `points`, with a parabola from `radii[k]` before corner k to `radii[k]` behind it.

    Its tangent is constant on edges and linear in between, so the position on it is the length along the polyline.
    """

    def __init__(self, points, radii):
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        self.corners = np.concatenate([[0.0], np.cumsum(lengths)])
        self.breaks = np.stack([self.corners[:-1] + radii[:-1], self.corners[1:] - radii[1:]], axis=1).ravel()
        self.tangents = steps / lengths[:, None]
        self.start = points[0]
        self.offset = make_interp_spline(self.breaks, np.repeat(self.tangents, 2, axis=0), k=1).antiderivative()

    def __call__(self, s, order=0):
        return self.offset(s, order) + (self.start if order == 0 else 0)

    dof = property(lambda self: len(self.start))
    path_interval = property(lambda self: np.array([0.0, self.breaks[-1]]))


def reach(scene, links):
    """A bound on how far any point of the chain `links` is from the axis of any of its revolute joints [m]."""
    origins = scene.poses(np.zeros(scene.nq), of=links)[:, :3, 3]
    farthest = max(np.linalg.norm(scene.mesh(link)[0], axis=1).max() for link in links)
    return np.linalg.norm(np.diff(origins, axis=0), axis=1).sum() + farthest


def rounded(scene, points, lever):
    """The path through `points` with corners rounded as widely as is proved free. `lever`: what `reach` gives.

    A parabola is cut into chords so short that no point of the robot is farther from its place on the chord than half of the
    clearance. If all chords are free, the other half is kept.
    """
    edges = scene.check_segments(points[:-1], points[1:])["free"]
    if not edges.all():
        raise ValueError(f"points: the edge from point {np.argmin(edges)} is not proved free; repair the path first")
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not lengths.all():
        raise ValueError(f"points: {np.argmin(lengths)} and the next are the same; leave one out")
    if scene.clearance == 0:
        raise ValueError("scene: its clearance is 0; corners are rounded only within a clearance")
    radii = np.concatenate([[0.0], 0.45 * np.minimum(lengths[:-1], lengths[1:]), [0.0]])
    for k in range(1, len(points) - 1):
        for _ in range(16):
            curve = Curve(points, radii)
            # A parabola of n chords strays from them by 1/8 of its second derivative, times their length squared.
            turn = np.abs(curve.tangents[k] - curve.tangents[k - 1]).sum()
            chords = int(np.ceil(np.sqrt(lever * turn * radii[k] / 4 / (scene.clearance / 2)))) + 1
            q = curve(np.linspace(curve.corners[k] - radii[k], curve.corners[k] + radii[k], chords + 1))
            if scene.check_segments(q[:-1], q[1:])["free"].all():
                break
            radii[k] /= 2
        else:
            raise ValueError(f"points: no parabola at point {k} is proved free; plan with a larger clearance")
    return Curve(points, radii)


def timed(curve, velocity, acceleration):
    """The fastest motion along `curve` from rest to rest that TOPP-RA finds within the limits (nq,) [rad/s, rad/s^2].

    The result is called with times, and with order 1 or 2 for velocities or accelerations; `duration` is its length.
    """
    limits = [
        toppra.constraint.JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    grid = np.unique(np.concatenate([np.linspace(a, b, 31) for a, b in zip(curve.breaks[:-1], curve.breaks[1:])]))
    _, speed, _ = toppra.algorithm.TOPPRA(limits, curve, gridpoints=grid, solver_wrapper="seidel").compute_parameterization(0, 0)
    if speed is None or np.isnan(speed).any():
        raise RuntimeError("TOPP-RA found no times")
    # TOPP-RA keeps the limits at points of the grid. Between two of them tangent and squared speed are linear, so the ends bound
    # both limits; the motion is slowed down by what it exceeds them.
    tangent, bend = curve(grid, 1), curve((grid[:-1] + grid[1:]) / 2, 2)
    gain = np.diff(speed**2) / np.diff(grid) / 2
    slow = 1.0
    for here in (slice(None, -1), slice(1, None)):
        fastest = np.abs(tangent[here]) * np.maximum(speed[:-1], speed[1:])[:, None]
        strongest = np.abs(tangent[here] * gain[:, None] + bend * speed[here, None] ** 2)
        slow = max(slow, (fastest / velocity).max(), np.sqrt((strongest / acceleration).max()))
    # Not TOPP-RA's default, which fits a spline to the result and so leaves the curve.
    return ParametrizeConstAccel(curve, grid, speed / slow)


def stopping(points, velocity, acceleration):
    """The least duration if the robot stops at every point [s]."""
    total = 0.0
    for step in np.abs(np.diff(points, axis=0)):
        v, a = 1 / (step / velocity).max(), 1 / (step / acceleration).max()  # in edges, not in rad
        total += 1 / v + v / a if v * v < a else 2 / np.sqrt(a)
    return total


def main():
    scene = extricate.Scene.builtin("shelf-arm")
    start, goal = scene.sample(2, seed=41, colliding=False)
    points = scene.plan(start, goal).points
    velocity, acceleration = np.full(scene.nq, 2.0), np.full(scene.nq, 5.0)
    links = [body for body in scene.bodies if body.startswith(("base", "link", "gripper"))]
    curve = rounded(scene, points, reach(scene, links))
    motion = timed(curve, velocity, acceleration)
    stops = stopping(points, velocity, acceleration)
    print(f"path of {len(points)} points: {motion.duration:.2f} s, {stops:.2f} s if the robot stops at each")

    times = np.linspace(0, motion.duration, int(1000 * motion.duration) + 1)
    q, rates, accelerations = (motion(times, order) for order in range(3))
    print(
        f"at {len(q)} instants bodies are {1e3 * scene.distances(q).min():.2f} mm apart or more;"
        f" at most {np.abs(rates).max():.2f} rad/s and {np.abs(accelerations).max():.2f} rad/s^2"
    )
    spline = toppra.SplineInterpolator(curve.corners, points)(np.linspace(0, curve.corners[-1], 10_000))
    lost = 1 - scene.check(spline).mean()
    print(f"a cubic spline through the same points would collide along {100 * lost:.0f} % of its length")
    return scene, points, motion, (q, rates, accelerations), (velocity, acceleration), stops, lost


if __name__ == "__main__":
    main()
