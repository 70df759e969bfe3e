"""A MuJoCo model as a robot of extricate, beside MuJoCo itself: verdicts of random poses, and penetration at witnesses.

    python3 bench/mujoco_hand.py FOLDER            fetches the Shadow hand of the PyPI package gymnasium-robotics into FOLDER
    python3 bench/mujoco_hand.py MODEL.xml         another model

Needs `pip install 'extricate[mujoco]'`. Exits with 1 where fewer than 0.99 of the verdicts agree, one differs by more than the
clearance, or a witness penetrates."""
import subprocess
import sys
import warnings
import zipfile
from pathlib import Path

import mujoco
import numpy as np

import extricate

POSES, WITNESSES = 2000, 200
HAND = "gymnasium_robotics/envs/assets/hand/reach.xml"


def fetched(folder):
    if not (folder / HAND).exists():
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(folder), "gymnasium-robotics"]
        subprocess.run(command, check=True)
        for wheel in folder.glob("gymnasium_robotics-*.whl"):
            zipfile.ZipFile(wheel).extractall(folder)
    return folder / HAND


def poses(scene):
    rng = np.random.default_rng(0)
    Q = rng.uniform(scene.lower, scene.upper, (POSES, scene.nq))
    for joint in scene.joints:
        if joint.kind in ("floating", "spherical"):
            turns = rng.normal(size=(POSES, 4))
            Q[:, joint.stop - 4 : joint.stop] = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    return Q


def main():
    path = Path(sys.argv[1])
    model = mujoco.MjModel.from_xml_path(str(path if path.suffix == ".xml" else fetched(path)))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        robot = extricate.Robot.from_mujoco(model)
        scene = extricate.Scene(robot)
    for warning in told:
        print(f"warning: {warning.message}")
    data = mujoco.MjData(model)

    def depth(qpos):
        """Returns the signed distance of the deepest pair [m]; more than 0 if none touches."""
        data.qpos[:] = qpos
        mujoco.mj_fwdPosition(model, data)
        return min([contact.dist for contact in data.contact[: data.ncon]], default=np.inf)

    Q = poses(scene)
    mine, theirs = ~scene.check(Q), np.array([depth(qpos) < 0 for qpos in robot.qpos(Q)])
    differ = mine != theirs
    off = np.abs(scene.distances(Q[differ])).max(initial=0.0)
    witnesses = scene.query_batch(Q[mine][:WITNESSES])["witness"]
    good = sum(depth(qpos) >= 0 for qpos in robot.qpos(witnesses))
    print(f"{scene}: colliding {mine.mean():.4f} here, {theirs.mean():.4f} in MuJoCo")
    print(f"same verdict {1 - differ.mean():.4f}; where they differ, {off:.1e} m apart at most (clearance {scene.clearance:.0e})")
    print(f"witnesses without penetration in MuJoCo: {good} of {len(witnesses)}")
    return int(differ.mean() > 0.01 or off > scene.clearance or good < len(witnesses))


if __name__ == "__main__":
    sys.exit(main())
