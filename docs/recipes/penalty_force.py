"""A penalty force from the depth, and how much energy it makes along closed loops: of queries, and of a continuous stream."""

import functools

import numpy as np

import extricate


def force(answer, stiffness):
    """Generalized force (nv,) [N m of hinges, N of slides]: minus the gradient of the energy stiffness * depth^2 / 2."""
    return -stiffness * answer.depth * answer.gradient


def loops(scene, count, steps, radius, seed):
    """Closed circles about colliding configurations, in random planes: (count, steps + 1, nq)."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0, 2 * np.pi, steps + 1)[:, None]
    found = []
    for center in scene.sample(20 * count, seed=seed, colliding=True):
        first, second = np.linalg.qr(rng.normal(size=(scene.nq, 2)))[0].T
        loop = center + radius * (np.cos(turn) * first + np.sin(turn) * second)
        loop[-1] = loop[0]
        # Limits have a depth too, and it is not that of a collision.
        if (loop > scene.lower).all() and (loop < scene.upper).all():
            found.append(loop)
        if len(found) == count:
            break
    return np.array(found)


def work(loop, query, stiffness):
    """Work of the force along a loop by the trapezoidal rule, and the greatest energy on it [J]."""
    answers = [query(q) for q in loop]
    forces = np.array([force(answer, stiffness) for answer in answers])
    done = float((0.5 * (forces[1:] + forces[:-1]) * np.diff(loop, axis=0)).sum())
    return done, 0.5 * stiffness * max(answer.depth for answer in answers) ** 2


def main(count=10, steps=1000, stiffness=1000.0):
    scene = extricate.Scene.builtin("planar-arm")
    model = extricate.learn(scene, labels=50_000)
    shares = {"query": [], "continuous stream": []}
    for loop in loops(scene, count, steps, radius=0.3, seed=3):
        # With a gap, a query may end at an exit that is up to 15 % farther than the nearest one, and its depth jumps.
        single = functools.partial(model.query, gap=0.0)
        for name, query in (("query", single), ("continuous stream", model.stream(continuous=True).query)):
            done, peak = work(loop, query, stiffness)
            shares[name].append(abs(done) / peak)
    for name, share in shares.items():
        share = np.array(share)
        print(f"{name}: |work| of {len(share)} closed loops over the peak energy: median {np.median(share):.2e}, most {share.max():.2e},"
              f" below 1 %: {(share < 0.01).mean():.0%}")
    return shares


if __name__ == "__main__":
    main()
