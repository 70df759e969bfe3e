"""A plan of VAMP or cuRobo is proved, its collisions are repaired, and it is given back in the planner's order of joints.

Both take the robot as spheres, so what is free for them may collide with its meshes, or with what their world lacks. The plan comes
as a file of `joint_names` and `position`, one row a configuration. In their programs it is written so:

    VAMP:    {"joint_names": vamp.panda.joint_names(), "position": result.path.numpy().tolist()}
    cuRobo:  plan = result.get_interpolated_plan()
             {"joint_names": plan.joint_names, "position": plan.position.cpu().tolist()}

VAMP's rows are corners of a path, without times. cuRobo's are a time step apart, and a repaired plan no longer is: `toppra_times.py`
gives it times. Neither planner is needed here. The plan of this program comes from a stand-in that sees the shelf as some 220 small balls
and goes between them. It has its joints in reverse, in single precision, and its start collides.
"""

import json
import pathlib
import tempfile

import numpy as np

import extricate


def proved(scene, joint_names, rows):
    """Returns a path (m, nq) in place of the plan `rows` (n, nq), two or more, both in the order of `joint_names`; the row from which
    on all of it is proved free; and sentences that say what was wrong.

    That row is 0 if the start is free. If not, an escape leads to it, on which no collision gets worse. Rows that are free and joined
    by free edges stay; a goal that collides is moved. Raises ValueError for joints that are not the scene's, and RuntimeError if no escape
    or no repair is found.
    """
    own = [joint.name for joint in scene.joints]
    if sorted(joint_names) != sorted(own):
        raise ValueError(f"joint_names: {list(joint_names)}, expected {own} in any order")
    path = np.asarray(rows, dtype=float)[:, [joint_names.index(name) for name in own]]
    wrong = []

    escape = scene.escape(path[0], toward=path[1])  # the start alone, if it is free
    if escape.points is None:
        raise RuntimeError(f"row 0 collides, and no escape was found; needed tolerance: {escape.needed_tolerance} m")
    for (a, b), distance in escape.colliding:
        wrong.append(f"row 0: {a} is {-1e3 * distance:.1f} mm inside {b}")
    path[0] = escape.points[-1]

    edges = scene.check_segments(path[:-1], path[1:])
    for k in np.flatnonzero(~edges["free"]):
        a, b = scene.pairs[edges["pair"][k]]
        found = "collides with" if edges["contact"][k] else "comes too near to"
        wrong.append(f"edge from row {k} to {k + 1}: {a} {found} {b} at {100 * edges['at'][k]:.0f} % of it")
    repaired = scene.repair(path)
    if repaired.points is None:
        raise RuntimeError(f"no repair was found; {'; '.join(wrong)}")
    points = np.concatenate([escape.points[:-1], repaired.points])
    return points[:, [own.index(name) for name in joint_names]], escape.free_from, wrong


def write_stand_in(scene, file):
    """Writes the plan of a planner that sees the shelf as balls, 0.1 m apart."""
    boards = [body for body in scene.bodies if body.startswith(("shelf", "board"))]
    balls = []
    for board, pose in zip(boards, scene.poses(scene.lower, of=boards)):
        half = scene.mesh(board)[0].max(axis=0)
        axes = [np.linspace(-h, h, int(20 * h) + 1) if h > 0.02 else [0.0] for h in half]
        for at in np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3):
            balls.append(extricate.Sphere(0.02, pose[:3, :3] @ at + pose[:3, 3]))
    seen = scene.without(boards).with_obstacles(balls)
    starts = scene.sample(8, seed=40, colliding=True)
    start, goal = starts[seen.check(starts)][0], scene.sample(1, seed=41, colliding=False)[0]
    rows = seen.plan(start, goal).points[:, ::-1].astype(np.float32)
    names = [joint.name for joint in scene.joints][::-1]
    file.write_text(json.dumps({"joint_names": names, "position": rows.tolist()}))


def main(folder=None):
    scene = extricate.Scene.builtin("shelf-arm")
    file = pathlib.Path(folder or tempfile.mkdtemp()) / "plan.json"
    write_stand_in(scene, file)

    plan = json.loads(file.read_text())
    names, rows = plan["joint_names"], np.array(plan["position"])
    path, free_from, wrong = proved(scene, names, rows)
    print(f"plan of {len(rows)} rows, joints {names[0]} to {names[-1]}")
    print("\n".join(wrong))
    print(f"repaired: {len(path)} rows, every edge from row {free_from} on is proved free")
    file.write_text(json.dumps({"joint_names": names, "position": path.tolist()}))
    return scene, names, rows, path, free_from, wrong


if __name__ == "__main__":
    main()
