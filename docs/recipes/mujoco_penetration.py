"""Pushes a state of MuJoCo out of penetration, along the nearest exit."""

import mujoco
import numpy as np

import extricate


def push_out(model, mujoco_model, data):
    """Sets `data.qpos` to the nearest free configuration and the velocity to zero; returns the answer."""
    places = [mujoco_model.joint(joint.name).qposadr[0] for joint in model.scene.joints]
    positions = {joint.name: data.qpos[at] for joint, at in zip(model.scene.joints, places)}
    answer = model.query(model.scene.config(positions))
    data.qpos[places] = answer.witness
    data.qvel[:] = 0
    mujoco.mj_forward(mujoco_model, data)
    return answer


def deepest(data):
    """Penetration of the deepest contact [m]; 0 where nothing penetrates."""
    return max([0.0, *(-data.contact.dist[: data.ncon])])


def main():
    urdf = extricate.Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()
    cylinders = [(0.12, 0.4, (0.62, 0.3, 0)), (0.15, 0.4, (0.1, 0.75, 0)), (0.14, 0.4, (0.8, -0.35, 0))]
    scene = extricate.Scene(urdf, [extricate.Cylinder(r, length, at) for r, length, at in cylinders], clearance=1e-3)
    model = extricate.learn(scene, labels=50_000)

    spec = mujoco.MjSpec.from_string(urdf)
    for radius, length, position in cylinders:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, length / 2, 0], pos=position)
    mujoco_model = spec.compile()
    data = mujoco.MjData(mujoco_model)
    data.qpos[:] = [0.45, 0.1, -0.2]
    mujoco.mj_forward(mujoco_model, data)
    before = deepest(data)
    answer = push_out(model, mujoco_model, data)
    after = deepest(data)
    print(f"penetration {1e3 * before:.2f} mm before, {1e3 * after:.2f} mm after; joints moved by {answer.depth:.4f} rad")
    return before, after, np.array(data.qpos), answer


if __name__ == "__main__":
    main()
