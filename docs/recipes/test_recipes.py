"""Runs the recipes, and asks of each what it promises."""

import pathlib

import depth_image
import distance_field
import extricate
import hold_distance
import moveit_scene
import moving_obstacle
import mujoco
import mujoco_penetration
import numpy as np
import object_in_gripper
import octomap_file
import ompl_sampler
import ompl_start
import outside_plan
import penalty_force
import pinocchio_projection
import plot_plane
import pytest
import release_rows
import resets
import ros_bag
import start_outside
import toppra_times
import viser_sliders


def test_ompl_plans_from_the_repaired_start() -> None:
    scene, start, goal, path, answer = ompl_start.main()
    assert not scene.check(start) and answer.depth > 0 and answer.verified
    assert path[0] == pytest.approx(answer.witness) and path[-1] == pytest.approx(goal)
    assert scene.check(path).all()


def test_ompl_samples_by_retraction() -> None:
    scene, start, goal, path = ompl_sampler.main()
    assert path[0] == pytest.approx(start) and path[-1] == pytest.approx(goal)
    assert scene.check_segments(path[:-1], path[1:])["free"].all()


def test_coal_agrees_that_the_projection_is_free() -> None:
    before, after, answer = pinocchio_projection.main()
    assert before and not after and answer.verified


def test_nothing_penetrates_in_mujoco_any_more() -> None:
    before, after, qpos, answer = mujoco_penetration.main()
    assert before > 1e-3 and after == 0
    assert qpos == pytest.approx(answer.witness)


def test_viser_shows_the_nearest_exit() -> None:
    answer = viser_sliders.main(0)
    assert answer.depth > 0 and answer.verified


def test_the_plane_is_drawn(tmp_path: pathlib.Path) -> None:
    model, q, answer = plot_plane.main(str(tmp_path / "plane.png"))
    scene, support = model.scene, model.support_vectors
    assert 0 < scene.check(support).mean() < 1 and len(support) <= model.statistics["support_vectors"]
    assert not scene.check(q) and scene.check(answer.witness)
    assert (tmp_path / "plane.png").stat().st_size > 10_000


def test_files_of_hands_are_released_in_every_place(tmp_path: pathlib.Path) -> None:
    # scripts/check-fleet.sh runs it on Ray.
    found = {place: release_rows.main(tmp_path, place, 600) for place in ("here", "processes", "dask")}
    for released in found.values():
        assert (released["row"] == np.arange(600)).all() and (released["config"] == found["here"]["config"]).all() and released["verified"].all()


def test_resets_are_the_same_in_the_arrays_of_every_simulator() -> None:
    mujoco_model, qpos, first, (root, joints), joint_q = resets.main()
    data = mujoco.MjData(mujoco_model)

    def penetrates(state: np.ndarray) -> bool:
        data.qpos[:] = state
        mujoco.mj_forward(mujoco_model, data)
        return bool((data.contact.dist[: data.ncon] < 0).any())

    before = np.array([penetrates(state) for state in qpos])
    moved = (first != qpos).any(axis=1)
    assert before.sum() > 20 and moved[before].all() and not any(penetrates(state) for state in first)
    # Isaac Lab has both hips before the knees; Newton has w last.
    assert np.allclose(joints[:, [0, 2, 1, 3]], first[:, 7:], atol=1e-9)
    worlds = joint_q.reshape(len(qpos), -1)
    assert np.allclose(worlds[:, 7:], first[:, 7:], atol=1e-9)
    for positions, quaternions in ((root[:, :3], root[:, 3:]), (worlds[:, :3], worlds[:, [6, 3, 4, 5]])):
        assert np.allclose(positions, first[:, :3], atol=1e-9)
        assert np.abs((quaternions * first[:, 3:7]).sum(axis=1)) == pytest.approx(1, abs=1e-9)


def test_a_start_beyond_a_limit_is_brought_back() -> None:
    scene, measured, witness, outside = start_outside.main()
    assert outside == ["joint_4"] and scene.check(witness)
    assert np.abs(witness - measured).max() == pytest.approx(0.5e-3)


def test_a_moving_obstacle_is_followed() -> None:
    last, poses, frames = moving_obstacle.main()
    hit = [frame for frame in frames if frame[1] > 0]
    assert len(frames) == 200 and len(hit) > 20
    assert last.check(frames[-1][0]) and len(last.bodies) == len(set(last.bodies))


def test_an_object_in_the_gripper_keeps_away_from_the_world() -> None:
    empty, held, put_down, answers = object_in_gripper.main()
    assert len(answers) > 20 and all(answer.verified and held.check(answer.witness) for answer in answers)
    assert all("can" in pair for answer in answers for pair in answer.colliding)
    assert put_down.pairs == empty.pairs


def test_a_planning_scene_and_a_joint_state_are_enough(tmp_path: pathlib.Path) -> None:
    world, start, answer, repaired, near = moveit_scene.main(tmp_path)
    assert world.bodies[-2:] == ["table", "can"] and ("link_7", "can") not in world.pairs
    assert not world.check(start) and answer.verified and world.check(answer.witness)
    assert list(repaired)[:2] == ["joint_1", "joint_2"] and (world.config(repaired) == answer.witness).all()
    assert len(near) and (near["distance"] < 0.02).all() and (near["distance"] > 0).any()


def test_a_bag_is_read_and_the_answer_is_written_into_one(tmp_path: pathlib.Path) -> None:
    world, octomap, cells, q, answer, again = ros_bag.main(tmp_path)
    assert world.bodies[-4:] == ["table", "box", "<octomap>", "can"]
    # The octomap is OctoMap's own; it holds every cell that was set.
    found = np.asarray(extricate.ros.octomap(octomap, None).occupied)
    assert len(found) == cells and (found[:, 0] == 12).all() and sorted(set(found[:, 1])) == list(range(-12, 12))
    assert answer.colliding == [("<octomap>", "can")] and answer.verified
    assert again == pytest.approx(answer.witness, abs=1e-15) and world.check(answer.witness)


def test_the_map_of_a_file_is_one_obstacle() -> None:
    world, q, answer = octomap_file.main()
    assert world.bodies[-1] == "map" and any("map" in pair for pair in answer.colliding)
    assert answer.verified and world.check(answer.witness)


def test_a_depth_image_is_one_obstacle() -> None:
    world, cloud, q, answer = depth_image.main()
    assert world.bodies[-1] == "seen" and len(cloud) > 10_000
    assert cloud[:, 0] == pytest.approx(0.45) and any("seen" in pair for pair in answer.colliding)
    assert answer.verified and world.check(answer.witness)


def test_a_penalty_force_makes_little_energy_along_closed_loops() -> None:
    shares = {name: np.array(share) for name, share in penalty_force.main().items()}
    asked, continuous = shares["query"], shares["continuous stream"]
    assert len(asked) == len(continuous) == 10
    assert np.median(asked) < 0.01 and asked.max() < 0.05
    # A proxy that is held behind something remembers its path: this force has no potential.
    assert continuous.max() > 0.05


def test_times_keep_the_proof_and_the_limits() -> None:
    scene, points, motion, (q, rates, accelerations), (velocity, acceleration), stops, lost = toppra_times.main()
    assert q[0] == pytest.approx(points[0]) and q[-1] == pytest.approx(points[-1])
    assert scene.distances(q).min() > scene.clearance / 2
    assert scene.check_segments(q[:-1], q[1:])["free"].all()
    assert (np.abs(rates) <= velocity + 1e-9).all() and (np.abs(accelerations) <= acceleration + 1e-9).all()
    # The derivatives belong to the positions: central differences agree where no blend begins or ends.
    step = motion.duration / (len(q) - 1)
    assert np.median(np.abs((q[2:] - q[:-2]) / (2 * step) - rates[1:-1])) < 1e-3
    assert motion.duration < 0.95 * stops and lost > 0.05


def test_times_are_refused_for_a_path_that_collides() -> None:
    scene = extricate.Scene.builtin("shelf-arm")
    points = scene.sample(2, seed=41, colliding=False)
    with pytest.raises(ValueError, match="from point 0 is not proved free"):
        toppra_times.rounded(scene, points, 1.5)


def test_a_plan_of_another_program_is_proved_and_repaired(tmp_path: pathlib.Path) -> None:
    scene, names, rows, path, free_from, wrong = outside_plan.main(tmp_path)
    own = [joint.name for joint in scene.joints]
    order = [names.index(name) for name in own]
    assert order != list(range(scene.nq))
    old, new = rows[:, order], path[:, order]
    assert not scene.check(old[0]) and wrong[0].startswith("row 0: ")
    assert scene.check_segments(old[1:-1], old[2:])["contact"].any() and any("edge from row 1 to 2" in line for line in wrong)
    assert free_from > 0 and scene.check_segments(new[free_from:-1], new[free_from + 1 :])["free"].all()
    assert (path[0] == rows[0]).all() and (path[-1] == rows[-1]).all()
    with pytest.raises(ValueError, match="in any order"):
        outside_plan.proved(scene, ["elbow", *names[1:]], rows)


def test_a_controller_holds_its_distance() -> None:
    scene, held, free, off = hold_distance.main()
    assert scene.distances(held).min() >= 0.01 and scene.distances(free).min() < 0
    assert np.median(off) < 0.03


def test_distances_are_learned_from_a_file(tmp_path: pathlib.Path) -> None:
    data, error, off, own = distance_field.main(tmp_path)
    distance, bound = data["distance"], data["bound"]
    assert data["q"].shape == data["gradient"].shape == (4000, 3) and (np.abs(bound) <= np.abs(distance)).all()
    # A step of the distance ends in contact; what is learned is less wrong than the mean distance.
    assert own.max() < 1e-4 and off.mean() < 0.05
    assert error.mean() < 0.5 * np.abs(distance - distance.mean()).mean()
