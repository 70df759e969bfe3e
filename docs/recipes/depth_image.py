"""Asks among the points of a depth image: back through the camera, without the robot's own, as one obstacle."""

import numpy as np

import extricate


def points(depth, fx, fy, cx, cy, camera):
    """World coordinates (n, 3) [m] of the pixels of a depth image [m] that see something.

    fx, fy, cx, cy: intrinsics [pixels]; camera: (4, 4), from camera coordinates (z ahead, x right, y down) to the world.
    """
    v, u = np.nonzero(np.isfinite(depth) & (depth > 0))
    z = depth[v, u]
    seen = np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z], axis=1)
    return seen @ camera[:3, :3].T + camera[:3, 3]


def main():
    scene = extricate.Scene.builtin("shelf-arm")
    # A camera 2 m ahead of the arm that looks back at it, and a wall of the room 0.45 m before the arm's base.
    camera = np.eye(4)
    camera[:3, :3] = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    camera[:3, 3] = [2.0, 0.0, 0.7]
    depth = np.full((120, 160), 1.55)
    cloud = points(depth, fx=150.0, fy=150.0, cx=80.0, cy=60.0, camera=camera)
    now = scene.sample(1, seed=2, colliding=False)[0]  # where the arm is while the picture is taken
    cloud = cloud[scene.robot_filter(cloud, now, 0.03)]
    world = scene.with_obstacles([extricate.Points(cloud, 0.01, name="seen")])
    q = next(q for q in scene.sample(2000, seed=1, colliding=False) if not world.check(q))
    answer = world.query(q)
    print(f"{len(cloud)} points as one body; {answer.depth:.4f} rad out of {answer.colliding}")
    return world, cloud, q, answer


if __name__ == "__main__":
    main()
