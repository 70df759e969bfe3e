"""The scenes of the benchmarks: built-in ones as the program exports them, and fetched robots among obstacles written here."""
import shutil

import numpy as np

from programs import extricate
from sides import BUILD, ROBOTS

FOLDER = BUILD / "scenes"
# Built-in scenes that the peers support: one robot with a fixed base, no mimic joints, the joint metric.
BUILT_IN = ["planar-arm", "shelf-arm"]

PANDA = """clearance = 1e-4
[[robot]]
urdf = "{robots}/panda_description/urdf/panda.urdf"
srdf = "{robots}/panda_description/srdf/panda.srdf"
packages = ["{packages}"]
geometry = "{geometry}"
locked = {{ panda_finger_joint1 = 0.02 }}
"""
UR5 = """clearance = 1e-4
[[robot]]
urdf = "{robots}/ur_description/urdf/ur5_robot.urdf"
srdf = "{robots}/ur_description/srdf/ur5.srdf"
packages = ["{packages}"]
geometry = "convex-hull"
"""
ALLEGRO = """clearance = 1e-4
[[robot]]
urdf = "{robots}/allegro_hand_description/urdf/allegro_right_hand.urdf"
packages = ["{packages}"]
[pairs]
disable = [["palm_link", "link_13.0"]]  # overlap by design of the model's boxes
"""


def written():
    """Name and file of every scene, easy ones first; the robots have to be there (scripts/fetch-robots.py)."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    found = {name: built_in(name) for name in BUILT_IN}
    torus(FOLDER / "torus.stl", major=0.25, minor=0.05)
    where = {"robots": ROBOTS, "packages": ROBOTS.parent.parent}
    box = obstacle("box", "box = [0.2, 0.6, 0.4]", [0.45, 0, 0.45])
    ring = obstacle("ring", 'mesh = "torus.stl"', [0.45, 0, 0.5], [0, np.pi / 2, 0]) + obstacle("table", "box = [1.2, 1.6, 0.05]", [0.3, 0, -0.03])
    texts = {
        "panda-box": PANDA.format(geometry="convex-hull", **where) + box,
        "ur5-shelf": UR5.format(**where) + shelf(),
        "allegro-ball": ALLEGRO.format(**where) + obstacle("ball", "sphere = 0.035", [0.09, 0, 0.05]),
        "panda-torus": PANDA.format(geometry="mesh", **where) + ring,
    }
    for name, text in texts.items():
        path = FOLDER / f"{name}.toml"
        path.write_text(text)
        found[name] = path
    return found


def built_in(name):
    """Exports a built-in scene again and returns its file."""
    folder = FOLDER / name
    shutil.rmtree(folder, ignore_errors=True)
    extricate("demo", "--scene", name, "--export", folder)
    return folder / f"{name}.toml"


def obstacle(name, shape, xyz, rpy=(0, 0, 0)):
    return f'[[obstacle]]\nname = "{name}"\nshape = {{ {shape} }}\npose = {{ xyz = {list(xyz)}, rpy = {list(rpy)} }}\n'


def shelf():
    """Returns a table under the arm and a shelf of three boards before it [m]."""
    middle, wide, deep, thick = 0.62, 0.8, 0.35, 0.03
    parts = [("table", [1.6, 1.6, 0.05], [0, 0, -0.06]), ("back", [thick, wide + thick, 0.9], [middle + deep / 2 + thick / 2, 0, 0.45])]
    parts += [(f"side_{k}", [deep, thick, 0.9], [middle, y, 0.45]) for k, y in enumerate((-wide / 2, wide / 2))]
    parts += [(f"board_{k}", [deep, wide - thick, thick], [middle, 0, z]) for k, z in enumerate((0.2, 0.5, 0.85))]
    return "".join(obstacle(name, f"box = {size}", xyz) for name, size, xyz in parts)


def torus(path, major, minor, around=64, across=24):
    """Returns a closed mesh of a ring in the plane z = 0, as binary STL [m]."""
    u, v = (np.arange(n) * 2 * np.pi / n for n in (around, across))
    radius = major + minor * np.cos(v)
    grid = np.stack([np.outer(np.cos(u), radius), np.outer(np.sin(u), radius), np.broadcast_to(minor * np.sin(v), (around, across))], axis=-1)
    right, up = np.roll(grid, -1, axis=0), np.roll(grid, -1, axis=1)
    corner = np.roll(right, -1, axis=1)
    triangles = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((grid, right, corner), (grid, corner, up))])
    rows = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = triangles
    path.write_bytes(b"torus".ljust(80) + np.uint32(len(rows)).astype("<u4").tobytes() + rows.tobytes())
