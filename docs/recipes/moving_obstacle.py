"""Asks, a hundred times a second, while an obstacle moves: only what moved is prepared anew."""

import time

import numpy as np

import extricate


def follow(scene, name, poses, q):
    """Witness and time [s] of every frame, for an obstacle that is at `poses` and an arm at `q`."""
    frames = []
    for pose in poses:
        began = time.perf_counter()
        scene = scene.moved({name: pose})
        answer = scene.query(q)
        frames.append((answer.witness, answer.depth, time.perf_counter() - began))
    return scene, frames


def main():
    scene = extricate.Scene.builtin("shelf-arm")
    q = scene.sample(30, seed=3, colliding=False)[16]  # reaches forward
    # A ball that flies through the arm.
    scene = scene.with_obstacles([extricate.Sphere(0.15, [0.4, -1.0, 0.6], name="ball")])
    scene.query(q)  # prepared once
    poses = [[0.4, y, 0.6] for y in np.linspace(-1.0, 1.0, 200)]
    last, frames = follow(scene, "ball", poses, q)
    times = np.array([seconds for _, _, seconds in frames])
    hit = sum(depth > 0 for _, depth, _ in frames)
    print(f"{hit} of {len(frames)} frames in collision; median {1e3 * np.median(times):.2f} ms a frame, at 100 Hz there are 10")
    return last, poses, frames


if __name__ == "__main__":
    main()
