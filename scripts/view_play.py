"""Checks of what pages play back: motions, paths and grasps. Called by check-view.py."""
from __future__ import annotations

import json
import re
from pathlib import Path

import chromium
from view_answers import check_readable
from view_pages import AXES, JOINTS, NUMBERS, PIXELS, Program, check_clean, check_numbers, check_words, expect, go, opened

GRIPPER = """<robot name="gripper"><link name="palm"/>
<link name="left"><collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
<link name="right"><collision><geometry><box size="0.02 0.02 0.02"/></geometry></collision></link>
<joint name="close_left" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="-0.1 0 0"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
<joint name="close_right" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0.1 0 0"/><axis xyz="-1 0 0"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/></joint></robot>"""
FRAMES = 30
# Presses the plot at a fraction of its width.
PRESS = """(() => {
    const plot = document.getElementById("plot"), box = plot.getBoundingClientRect();
    plot.setPointerCapture = () => {};
    plot.dispatchEvent(new PointerEvent("pointerdown", { clientX: box.left + %r * box.width, clientY: box.top + 5 }));
})()"""
# Plays all of a page, and returns for each picture the number of the query and the percentage of its exit.
WATCH = """new Promise((done, failed) => {
    const { controls, player } = extricate, seen = [], began = performance.now();
    const show = controls.show;
    controls.show = () => { seen.push([controls.query, controls.percent]); show(); };
    player.toggle();
    const wait = () => {
        if (player.timer === null) { controls.show = show; done(seen); }
        else if (performance.now() - began > 60000) failed(new Error("it still plays after a minute"));
        else setTimeout(wait, 20);
    };
    wait();
})"""


def check_motion(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    """Checks that frames of a motion play one after the other, with the answers of `query --stream`."""
    scene, folder = "cell/shelf-arm.toml", extricate.folder
    ends = [json.loads(line)["q"] for line in (folder / "q.jsonl").read_text().splitlines()[:2]]
    frames = [[a + 0.3 * k / FRAMES * (b - a) for a, b in zip(*ends)] for k in range(FRAMES)]
    (folder / "motion.jsonl").write_text("".join(f"{json.dumps(q)}\n" for q in frames))
    (folder / "a.jsonl").write_text(extricate.run(f"query {scene} --input motion.jsonl --stream --json"))
    address = opened(page, extricate, f"{scene} --input motion.jsonl --answers a.jsonl --stream")
    rows = [json.loads(line) for line in (folder / "a.jsonl").read_text().splitlines()]
    first = page.run(PIXELS)
    page.picture(pictures / "motion-first.png")
    seen = page.run(WATCH)
    page.picture(pictures / "motion-last.png")
    expect([at for at, _ in seen] == list(range(1, FRAMES)), f"frames were played as {seen}")
    expect(all(percent == 100 for _, percent in seen), "a motion is not watched at its witnesses")
    expect(page.run(PIXELS)["sum"] != first["sum"], "the picture of a motion stands still")
    compared = check_numbers(page, rows)
    page.run("extricate.controls.choose(0); document.getElementById('frames').value = '7'; "
             "document.getElementById('frames').dispatchEvent(new Event('input'))")
    expect(page.run("extricate.controls.query") == 7, "the slider of frames chooses none")
    # The plot of a motion has every frame, and a press chooses the one at its place.
    points = page.run("document.querySelector('#plot .line').getAttribute('points').split(' ').length")
    expect(points == FRAMES, f"the plot has {points} frames")
    upright, level = page.run(AXES)
    expect(re.search(r"depth .* and lower bound .*, from 0 rad to .* rad", upright), f"the vertical axis is labelled {upright}")
    expect(level == ["1", "frame of the motion", str(FRAMES)], f"the horizontal axis is labelled {level}")
    page.run(PRESS % 0.5)
    expect(page.run("extricate.controls.query") == FRAMES // 2, "a press of the plot chooses another frame")
    cursor = page.run("Number(document.querySelector('#plot .cursor').getAttribute('x1'))")
    expect(abs(cursor - page.run("extricate.controls.query") / (FRAMES - 1)) < 1e-9, f"the cursor is at {cursor}")
    check_readable(page, "motion", pictures)
    check_clean(page, "motion", address)
    print(f"motion: {FRAMES} frames played, {compared} numbers equal")


def check_paths(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    """Checks that paths play from waypoint to waypoint, and all paths of a page one after another."""
    scene, folder = "cell/shelf-arm.toml", extricate.folder
    waypoints = [json.loads(line)["q"] for line in extricate.run(f"sample {scene} -n 6 --seed 2").splitlines()]
    paths = [waypoints[:4], waypoints[3:]]
    (folder / "paths.jsonl").write_text(json.dumps(paths[0]) + "\n" + json.dumps({"path": paths[1]}) + "\n")
    address = opened(page, extricate, f"{scene} --paths paths.jsonl")
    outcomes = []
    for at, path in enumerate(paths):
        (folder / "segments.jsonl").write_text("".join(f"{json.dumps(ends)}\n" for ends in zip(path, path[1:])))
        outcomes = [row["outcome"] for row in extricate.rows(f"check {scene} --segments --input segments.jsonl --json")]
        page.run(f"extricate.controls.choose({at})")
        shown = page.run(NUMBERS)
        expected = [len(path), outcomes.count("free"), outcomes.count("contact")]
        found = [int(shown[key]) for key in ("waypoints", "free_segments", "colliding_segments")]
        expect(found == expected, f"path {at + 1}: the page has {found}, the program {expected}")
        # At the percentage of a waypoint, the robot is exactly there.
        for point in page.run("extricate.controls.shown.exits[0].way"):
            page.run(f"extricate.controls.go(100 * {point['at']!r})")
            now = page.run("[...document.querySelectorAll('#joints [data-joint=now]')].map(cell => Number(cell.dataset.value))")
            expect(max(abs(a - b) for a, b in zip(now, point["q"])) < 1e-9, f"path {at + 1}: {now} at {point}")
        # The plot is the program's distance of the nearest pair at the ends.
        (folder / "ends.jsonl").write_text("".join(f"{json.dumps(q)}\n" for q in (path[0], path[-1])))
        ends = [row["clearance"] for row in extricate.rows(f"check {scene} --input ends.jsonl --json")]
        shown = page.run("extricate.controls.shown.exits[0].distances")
        expect(len(shown) == 101 and max(abs(a - b) for a, b in zip(ends, (shown[0], shown[-1]))) < 1e-6, f"path {at + 1}: distances {shown}, ends {ends}")
        strip = page.run("[...document.querySelectorAll('#proved i')].map(part => part.className)")
        expect(strip == [{"free": "f", "contact": "c"}.get(outcome, "u") for outcome in outcomes], f"path {at + 1}: the strip is {strip}")
    check_words(page)
    page.run("extricate.controls.choose(0); extricate.controls.go(0)")
    page.run(PRESS % 0.3)
    expect(page.run("extricate.controls.percent") == 30, "a press of the plot does not go there")
    page.picture(pictures / "path.png")
    page.run("document.activeElement.blur()")
    seen = page.run(WATCH)
    expect({at for at, _ in seen} == {0, 1} and seen[-1] == [1, 100], f"paths were played as {seen[:3]} to {seen[-1]}")
    expect(all(any(at == k and 20 < percent < 80 for at, percent in seen) for k in (0, 1)), "a path was not played through")
    expect(page.run(AXES)[1][1] == "share of the path", "the horizontal axis of a path is not named")
    check_readable(page, "paths", pictures)
    check_clean(page, "paths", address)
    print(f"paths: {len(paths)} played, in {len(seen)} pictures")


def check_grasps(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    """Checks that grasps are shown from the query to the release, with the numbers of `grasp --json`."""
    folder = extricate.folder
    (folder / "gripper.urdf").write_text(GRIPPER)
    ball = '[[robot]]\nurdf = "gripper.urdf"\n[[obstacle]]\nname = "ball"\nshape = { sphere = 0.03 }\n'
    (folder / "grip.toml").write_text("clearance = 1e-4\n" + ball)
    (folder / "g.jsonl").write_text("[0.08, 0.065]\n[0.07, 0.075]\n")
    (folder / "a.jsonl").write_text(extricate.run("grasp grip.toml --input g.jsonl --object ball --json"))
    address = opened(page, extricate, "grip.toml --input g.jsonl --answers a.jsonl")
    for at, text in enumerate((folder / "a.jsonl").read_text().splitlines()):
        row = json.loads(text)
        page.run(f"extricate.controls.choose({at})")
        shown = page.run(NUMBERS)
        for key in ("moved", "depth_before", "verified", "touched", "kept", "kept_sides"):
            expect(json.loads(shown[key]) == row[key], f"grasp {at + 1}: {key}: the page has {shown[key]}, the program {row[key]}")
        expect(json.loads(shown["epsilon"]) == row["quality"]["epsilon"], f"grasp {at + 1}: epsilon {shown['epsilon']}")
        expect(page.run(JOINTS)[1] == row["config"], f"grasp {at + 1}: another release")
    seen = [go(page, percent) for percent in (0, 100)]
    expect(seen[0]["hit"] > 100 and seen[1]["free"] > 4 * seen[0]["free"], f"a grasp is not shown as it is: {seen}")
    check_words(page)
    page.picture(pictures / "grasp.png")
    check_clean(page, "grasps", address)
    check_objects(page, extricate, pictures)
    print("grasps: 2 shown, numbers equal, and 2 with objects of their own")


TETRAHEDRON = "v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n"


def check_objects(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    """Checks that a grasp is shown with the object that its line names."""
    folder = extricate.folder
    (folder / "meshes").mkdir()
    (folder / "meshes/cup.obj").write_text(TETRAHEDRON)
    (folder / "hand.toml").write_text('clearance = 1e-4\n[[robot]]\nurdf = "gripper.urdf"\n')
    lines = [json.dumps({"q": [0.06, 0.07], "object": "cup.obj", "scale": scale}) + "\n" for scale in (0.02, 0.04)]
    (folder / "objects.jsonl").write_text("".join(lines))
    (folder / "released.jsonl").write_text(extricate.run("grasp hand.toml --input objects.jsonl --objects meshes --json"))
    address = opened(page, extricate, "hand.toml --input objects.jsonl --answers released.jsonl --objects meshes")
    sums = []
    for at in range(2):
        page.run(f"extricate.controls.choose({at}); extricate.controls.go(0)")
        expect(page.run("extricate.stage.bodies.filter(made => made && made.edges).length") == 1, f"grasp {at + 1}: no object is drawn")
        expect("object" in page.run("document.getElementById('state').textContent"), f"grasp {at + 1}: nothing touches the object")
        sums.append(page.run(PIXELS)["sum"])
    expect(sums[0] != sums[1], "another object looks the same")
    page.picture(pictures / "objects.png")
    check_clean(page, "objects", address)
