"""Holds an object after a grasp: it moves with the gripper, may touch it, and must not hit anything else."""

import numpy as np

import extricate


def main():
    empty = extricate.Scene.builtin("shelf-arm")
    model = extricate.learn(empty, labels=20_000)  # of the empty gripper
    can = extricate.Cylinder(0.03, 0.25, name="can")
    held = empty.attach(can, link="gripper", pose=[0, 0, 0.15], touch=["gripper", "link_7"])
    # Free for the empty gripper; with the can in it, not.
    Q = empty.sample(2000, seed=5, colliding=False)
    Q = Q[~held.check(Q)]
    asked = model.in_world(held)
    answers = [asked.query(q) for q in Q]
    moved = np.median([answer.max_displacement for answer in answers])
    print(f"the can alone collides in {len(Q)} of 2000 free configurations; median exit {100 * moved:.1f} cm")
    put_down = held.without(["can"])
    return empty, held, put_down, answers


if __name__ == "__main__":
    main()
