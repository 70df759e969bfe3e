"""Plots the configuration space of two joints: what collides, boundary samples, support vectors, a query and its ways out."""

import sys

import matplotlib.pyplot as plt
import numpy as np

import extricate


def plot(model, q, file, size=300):
    """Draws a scene of two coordinates and the answer to `q` into `file`; returns the answer."""
    scene = model.scene
    (x0, y0), (x1, y1) = scene.lower, scene.upper
    x, y = np.meshgrid(np.linspace(x0, x1, size), np.linspace(y0, y1, size))
    free = scene.check(np.column_stack([x.ravel(), y.ravel()])).reshape(size, size)
    answer = model.query(q, exits=3)
    figure, axes = plt.subplots(figsize=(7, 6))
    axes.imshow(~free, origin="lower", extent=(x0, x1, y0, y1), cmap="Greys", alpha=0.4, aspect="auto")
    axes.scatter(*model.boundary.T, s=3, color="tab:blue", label="boundary samples")
    support = model.support_vectors
    is_free = scene.check(support)
    axes.scatter(*support[is_free].T, s=14, facecolors="none", edgecolors="tab:green", label="support vectors, free")
    axes.scatter(*support[~is_free].T, s=14, marker="s", facecolors="none", edgecolors="tab:purple", label="support vectors, colliding")
    for found in answer.exits[1:]:
        axes.plot(*zip(q, found.witness), ":", color="tab:orange")
    axes.plot(*zip(q, answer.witness), "-", color="tab:red")
    axes.add_patch(plt.Circle(q, answer.lower_bound, fill=False, color="tab:green", label="proved: nothing free inside"))
    axes.plot(*q, "kx", label="query")
    axes.plot(*answer.witness, "o", color="tab:red", label=f"witness, {answer.depth:.3f} rad away")
    axes.set_xlabel(f"{scene.joints[0].name} [rad]")
    axes.set_ylabel(f"{scene.joints[1].name} [rad]")
    axes.legend(loc="upper right")
    figure.savefig(file, dpi=120)
    plt.close(figure)
    return answer


def main(file="plane.png"):
    urdf = extricate.Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()
    robot = extricate.Robot(urdf, locked={"joint_1": 0.3})
    obstacles = [extricate.Cylinder(0.12, 0.4, (0.62, 0.3, 0)), extricate.Cylinder(0.14, 0.4, (0.8, -0.35, 0))]
    scene = extricate.Scene(robot, obstacles)
    model = extricate.learn(scene, labels=20_000)
    q = scene.sample(1, seed=2, colliding=True)[0]
    answer = plot(model, q, file)
    print(f"wrote {file}: witness {answer.witness}, {len(answer.exits)} ways out")
    return model, q, answer


if __name__ == "__main__":
    main(*sys.argv[1:])
