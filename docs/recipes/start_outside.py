"""Repairs a start that an encoder reads half a milliradian beyond a joint limit, before anything refuses it."""

import numpy as np

import extricate


def repaired(scene, measured):
    """The nearest free configuration within the limits, and the joints that were beyond theirs."""
    answer = scene.query(measured)  # any finite configuration is a query
    return answer.witness, answer.outside, answer.depth


def main():
    scene = extricate.Scene.builtin("shelf-arm")
    start = scene.sample(1, seed=8, colliding=False)[0]
    measured = start.copy()
    measured[3] = scene.upper[3] + 0.5e-3
    if not scene.query(np.clip(measured, scene.lower, scene.upper)).free:
        raise SystemExit("the start collides besides: another seed")
    witness, outside, depth = repaired(scene, measured)
    print(f"{', '.join(outside)} beyond the limit; moved by {1e3 * depth:.3f} mrad")
    return scene, measured, witness, outside


if __name__ == "__main__":
    main()
