"""Checks that pages of the built-in scenes open on their answers, and that everybody can read and use them. Called by check-view.py."""
from __future__ import annotations

import itertools
import json
import os
import re
from pathlib import Path
from typing import Any

import chromium
from view_pages import AXES, PIXELS, Program, check_clean, check_numbers, expect

SCENES = ("shelf-arm", "planar-arm", "free-box", "dual-arm", "hand", "four-legs")
# Continuous integration opens two of them; EXTRICATE_VIEW_SCENES=6 opens all.
SCENES = SCENES[:int(os.environ.get("EXTRICATE_VIEW_SCENES", "2"))]
QUERIES, MOST_BYTES, LEAST_PIXELS, LEAST_DIFFERENCE = 6, 1_200_000, 200, 15.0
WIDTHS = ((1400, 900), (800, 1000), (390, 844))
# Pixels in the colour of collisions without those of the edges of obstacles.
LINKS = f"""(() => {{
    const edges = extricate.stage.bodies.filter(made => made && made.edges && made.edges.visible).map(made => made.edges);
    edges.forEach(part => {{ part.visible = false; }});
    const found = {PIXELS};
    edges.forEach(part => {{ part.visible = true; }});
    return found;
}})()"""
# Texts of which a part lies outside the window, or outside an element that hides what is beyond it.
CUT = """(() => {
    const cut = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    const isOut = (inner, outer) => inner.left < outer.left - 1 || inner.right > outer.right + 1;
    while (walker.nextNode()) {
        const node = walker.currentNode, parent = node.parentElement;
        if (!node.data.trim() || ["SCRIPT", "STYLE", "OPTION", "NOSCRIPT"].includes(parent.tagName)) continue;
        const range = document.createRange();
        range.selectNodeContents(node);
        for (const box of range.getClientRects()) {
            let isCut = isOut(box, { left: 0, right: innerWidth });
            for (let host = parent; host !== document.body && !isCut; host = host.parentElement) {
                const style = getComputedStyle(host);
                if (style.overflowX !== "visible") isCut = isOut(box, host.getBoundingClientRect());
            }
            if (isCut && box.width) cut.push(node.data);
        }
    }
    const context = document.createElement("canvas").getContext("2d");
    for (const list of document.querySelectorAll("select")) {
        context.font = getComputedStyle(list).font;
        if (list.clientWidth && context.measureText(list.selectedOptions[0].text).width > list.clientWidth - 30) cut.push(list.selectedOptions[0].text);
    }
    const boxes = ["legend", "scale", "tools"].map(id => document.getElementById(id).getBoundingClientRect());
    boxes.forEach((a, at) => boxes.slice(at + 1).forEach(b => {
        if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom) cut.push("a part of the picture covers another");
    }));
    return cut;
})()"""
FOCUSABLE = """[...document.querySelectorAll("button, input, select, summary, canvas[tabindex]")]
    .filter(found => !found.disabled && found.getClientRects().length && getComputedStyle(found).visibility !== "hidden")"""
DRAWN = "document.getElementById('drawn').textContent"
# Obstacles that have more balls together than a page draws.
MANY = 300
SETTLE = "new Promise(done => setTimeout(done, 100))"


def check_scenes(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    sizes, fewest, compared = [], [], 0
    for name in SCENES:
        extricate.run(f"demo --scene {name} --export {name}")
        scene, queries = f"{name}/{name}.toml", f"{name}.jsonl"
        (extricate.folder / queries).write_text(extricate.run(f"sample {scene} -n {QUERIES} --colliding --seed 1"))
        extricate.run(f"view {scene} --input {queries} --exits 3 -o {name}.html")
        path = extricate.folder / f"{name}.html"
        sizes.append(path.stat().st_size)
        page.open(path.as_uri())
        seen = [pixels_at_query(page, name, at) for at in range(QUERIES)]
        page.picture(pictures / f"open-{name}.png")
        fewest.append(min(seen))
        compared += check_numbers(page, extricate.rows(f"query {scene} --input {queries} --exits 3 --json"))
        check_readable(page, name, pictures)
        check_clean(page, name, path.as_uri())
    expect(max(sizes) <= MOST_BYTES, f"a page has {max(sizes)} bytes, at most {MOST_BYTES}")
    expect(min(fewest) >= LEAST_PIXELS, f"links that collide cover {dict(zip(SCENES, fewest))} pixels, at least {LEAST_PIXELS} in every scene")
    print(f"scenes: {len(SCENES)} with {QUERIES} queries each; links that collide cover at least {min(fewest)} pixels; {compared} numbers equal")
    page.open((extricate.folder / "shelf-arm.html").as_uri())
    check_opening(page)
    check_keyboard(page)
    check_parts(page)
    check_sentences(page)
    check_copies(page)
    check_link(page, (extricate.folder / "shelf-arm.html").as_uri())
    check_clouds(page, extricate, pictures)
    check_layers(page, extricate, pictures)
    page.open((extricate.folder / "shelf-arm.html").as_uri())
    least = check_colours(page.run("extricate.palettes"))
    page.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
    is_dark = page.run("""(async () => {
        const isDark = () => extricate.stage.world.background.getHex() === extricate.palettes[1].back;
        for (let turn = 0; turn < 50 && !isDark(); turn++) await new Promise(done => setTimeout(done, 100));
        return isDark();
    })()""")
    page.picture(pictures / "dark.png")
    expect(is_dark, "the night has the colours of the day")
    page.ask("Emulation.setEmulatedMedia", features=[])
    print(f"page: keyboard, names, pairs, bodies, copies and links work; colours differ by at least {least:.0f} for every eye")


def check_clouds(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    """Checks that 100,000 points and voxels are drawn, each where it is, without a stall."""
    scene = (extricate.folder / "shelf-arm/shelf-arm.toml").read_text().split("[[obstacle]]")[0]
    (extricate.folder / "shelf-arm/wall.xyz").write_text("".join(f"0.7 {k % 300 / 150 - 1} {k // 300 / 150}\n" for k in range(60_000)))
    (extricate.folder / "shelf-arm/hill.txt").write_text("".join(f"{k % 200} {k // 200} -4\n" for k in range(39_000)))
    (extricate.folder / "shelf-arm/few.txt").write_text("".join(f"{k % 10} {k // 10 % 10} {k // 100}\n" for k in range(500)))
    shapes = ('points = "wall.xyz", radius = 0.004', 'voxels = "hill.txt", size = 0.01', 'voxels = "few.txt", size = 0.03')
    scene += "".join(f'[[obstacle]]\nname = "cloud{at}"\nshape = {{ {shape} }}\n' for at, shape in enumerate(shapes))
    (extricate.folder / "shelf-arm/clouds.toml").write_text(scene)
    extricate.run("view shelf-arm/clouds.toml -n 2 --seed 1 -o clouds.html")
    address = (extricate.folder / "clouds.html").as_uri()
    page.open(address)
    counts = page.run("extricate.stage.bodies.flatMap(made => made.clouds || []).map(cloud => cloud.count || cloud.geometry.attributes.position.count)")
    expect(counts == [60_000, 39_000, 500], f"clouds have {counts} centres")
    times = page.run(f"""(() => [10, 20, 30, 40, 50].map(percent => {{
        const began = performance.now(), {{ stage, controls }} = extricate, gl = stage.renderer.getContext();
        controls.go(percent);
        stage.drawAt(false);
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        return performance.now() - began;
    }}))()""")
    page.run("new Promise(done => setTimeout(done, 1000))")
    frames = page.run("""new Promise(done => {
        const { render } = extricate.stage.renderer.info, before = render.frame;
        setTimeout(() => done(render.frame - before), 500);
    })""")
    expect(frames == 0, f"{frames} pictures are drawn while nothing moves")
    page.picture(pictures / "clouds.png")
    check_clean(page, "clouds", address)
    print(f"clouds: {sum(counts):,} centres, {(extricate.folder / 'clouds.html').stat().st_size / 1e6:.2f} MB, a picture takes {sorted(times)[2]:.0f} ms")


LOOKS = """<robot name="r"><material name="leaf"><color rgba="0 0.8 0 1"/></material><link name="base"/><link name="arm">
<collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.05 0.05"/></geometry></collision>
<visual><origin xyz="0.25 0 0"/><geometry>%s</geometry><material name="leaf"/></visual></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint></robot>"""
GREEN = PIXELS.replace("g > 1.3 * b) hit++", "g > 1.3 * b) hit++;\n        if (g > 1.5 * r && g > 1.5 * b) green++").replace("sum = 0", "sum = 0, green = 0").replace("sum }", "sum, green }")


def check_layers(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    """Checks that keys show how links look and what stands for their shapes, and that a page without visual meshes says why."""
    (extricate.folder / "looks.urdf").write_text(LOOKS % '<cylinder radius="0.1" length="0.3"/>')
    (extricate.folder / "looks.toml").write_text('[[robot]]\nurdf = "looks.urdf"\n[[obstacle]]\nname = "post"\nshape = { box = [0.1, 0.1, 0.3] }\npose = { xyz = [0.4, 0.1, 0] }\n')
    extricate.run("view looks.toml --q 0.1 -o looks.html")
    address = (extricate.folder / "looks.html").as_uri()
    page.open(address)
    page.run("extricate.controls.go(100)")
    seen = []
    for key in ("", "v", "v", "c", "c"):
        if key:
            page.press(key)
        seen.append(page.run(GREEN))
        page.picture(pictures / f"layers-{len(seen)}.png")
    expect(seen[0]["green"] == 0 and seen[1]["green"] > 1000, f"V does not show the colour of a material: {seen}")
    expect(seen[0] == seen[2] == seen[4] and seen[3]["sum"] != seen[0]["sum"], f"V and C do not show and hide their layers: {seen}")
    page.run("extricate.controls.go(0)")
    page.press("v")
    expect(page.run(GREEN)["green"] < 100, "a visual mesh of a link that collides keeps its colour")
    expect("balls" not in page.run(DRAWN), "the panel says that balls are left out")
    check_clean(page, "layers", address)
    posts = "".join(f'[[obstacle]]\nname = "post{at}"\nshape = {{ box = [0.1, 0.1, 0.3] }}\npose = {{ xyz = [{at + 1}, 3, 0] }}\n' for at in range(MANY))
    (extricate.folder / "posts.toml").write_text((extricate.folder / "looks.toml").read_text() + posts)
    extricate.run("view posts.toml --q 0.1 -o posts.html")
    page.open((extricate.folder / "posts.html").as_uri())
    text = page.run(f"extricate.stage.showLayer('stand_ins', true); extricate.controls.show(); {DRAWN}")
    expect(re.search(r"1,000 of [1-9],\d\d\d balls are drawn\.", text), f"of the balls that are left out the panel says: {text}")
    (extricate.folder / "looks.urdf").write_text(LOOKS % '<mesh filename="nowhere.stl"/>')
    extricate.run("view looks.toml --q 0.1 -o looks.html")
    page.open(address)
    expect("nowhere.stl" in page.run("document.getElementById('made').textContent"), "the page does not say why it has no visual meshes")


def pixels_at_query(page: chromium.Browser, name: str, at: int) -> int:
    page.run(f"extricate.controls.choose({at}); extricate.controls.go(0)")
    found = page.run(LINKS)
    expect(found["drawn"] > 1000, f"{name}, query {at + 1}: the picture is empty")
    return int(found["hit"])


def check_readable(page: chromium.Browser, name: str, pictures: Path) -> None:
    """Checks that no text is cut, at the query and at the exit, with all that is folded open."""
    for width, height in WIDTHS:
        page.size(width, height, touch=width < 500)
        for folded in (False, True):
            page.run(f"document.querySelectorAll('details').forEach(found => {{ found.open = {json.dumps(folded)}; }})")
            page.run(f"extricate.controls.go({100 * folded}); {SETTLE}")
            cut = page.run(CUT)
            if cut:
                page.picture(pictures / f"cut-{name}-{width}.png")
            expect(not cut, f"{name}: at a width of {width} px texts are cut: {cut[:5]}")
        page.run("document.querySelectorAll('details').forEach(found => { found.open = false; })")
    page.size(*WIDTHS[0])


def check_opening(page: chromium.Browser) -> None:
    """Checks that the page begins at the query with the exit as a ghost, and plays once."""
    page.reload()
    seen = page.run("""new Promise(done => {
        const wait = () => window.extricate && extricate.controls.isOpening ? done(0) : setTimeout(wait, 20);
        wait();
    }).then(() => new Promise(done => {
        const { controls, stage } = extricate, seen = [[controls.percent, stage.layers.target.visible]];
        const wait = () => controls.percent < 100 ? setTimeout(wait, 50) : done([...seen, [controls.percent, stage.layers.target.visible]]);
        wait();
    }))""")
    expect(seen[0] == [0, True] and seen[1][0] == 100, f"the page opens as {seen}")


def check_keyboard(page: chromium.Browser) -> None:
    """Checks that the Tab key reaches everything that can be pressed, and that keys turn the picture."""
    page.run("document.activeElement.blur(); extricate.controls.go(0); document.querySelectorAll('details').forEach(found => { found.open = true; })")
    page.run(SETTLE)
    count = page.run(f"{FOCUSABLE}.map((found, at) => {{ found.dataset.reached = ''; return at; }}).length")
    for _ in range(count + 2):
        page.press("Tab")
        page.run("if (document.activeElement.dataset) document.activeElement.dataset.reached = 'yes'")
    missed = page.run(f"{FOCUSABLE}.filter(found => found.dataset.reached !== 'yes').map(found => found.outerHTML.slice(0, 80))")
    expect(not missed, f"the keyboard does not reach {missed}")
    before = page.run("extricate.stage.renderer.domElement.focus(); extricate.stage.camera.position.toArray()")
    page.press("ArrowLeft")
    expect(page.run("extricate.stage.camera.position.toArray()") != before, "arrow keys do not turn the picture")
    page.run("document.activeElement.blur(); document.querySelectorAll('details').forEach(found => { found.open = false; })")
    page.press("r")


def check_parts(page: chromium.Browser) -> None:
    """Checks pairs of the list, names under the pointer and boxes of bodies."""
    page.run("extricate.controls.choose(0); extricate.controls.go(0)")
    whole = page.run(PIXELS)
    page.run("document.querySelector('#numbers .pair').click()")
    lit = page.run(PIXELS)
    expect(lit["hit"] > 0.5 * whole["hit"] and lit["sum"] != whole["sum"], f"a pair is not lit up: {whole}, {lit}")
    page.run("document.querySelector('#numbers .pair').click()")
    expect(page.run(PIXELS)["sum"] == whole["sum"], "a pair stays lit")
    name = page.run("""(async () => {
        const { stage, controls } = extricate, box = stage.renderer.domElement.getBoundingClientRect();
        const hit = new Set(controls.shown.answer.colliding.flatMap(pair => controls.shown.pairs[pair]));
        for (let y = 10; y < box.height; y += 8) for (let x = 10; x < box.width; x += 8) {
            const event = { clientX: box.left + x, clientY: box.top + y, buttons: 0 }, found = stage.bodyAt(event);
            if (!found || !hit.has(found.body) || !stage.bodies[found.body].moves) continue;
            stage.renderer.domElement.dispatchEvent(new PointerEvent("pointermove", event));
            await new Promise(done => setTimeout(done, 100));
            const note = document.getElementById("name");
            return [note.hidden ? "" : note.textContent, extricate.data.scene.bodies[found.body].name];
        }
    })()""")
    expect(name and name[0] == name[1], f"the name under the pointer is {name}")
    page.run("document.querySelector('#bodies details').open = true")
    page.run(SETTLE)
    page.run("window.shown = [...document.querySelectorAll('#bodies input')].filter(box => box.checked); shown.forEach(box => box.click())")
    empty = page.run(PIXELS)
    expect(empty["hit"] == 0 and empty["drawn"] == 0, f"bodies that are switched off are drawn: {empty}")
    page.run("shown.forEach(box => box.click())")
    expect(page.run(PIXELS)["sum"] == whole["sum"], "bodies do not come back")


def check_sentences(page: chromium.Browser) -> None:
    """Checks that the panel says what is proved, what is drawn, and what the axes of the plot are."""
    page.run("extricate.controls.choose(0); extricate.controls.go(0)")
    proof = page.run("document.getElementById('verdict').textContent")
    expect(re.search(r"Proved: no free configuration is nearer than [0-9.]+ rad\.", proof), f"the panel says of the proof: {proof}")
    words = ("Orange bodies", "blue robot", "blue ghost", "grey ghost", "Arrows")
    for percent, said in ((0, (True, False, True, False, True)), (100, (False, True, False, True, True))):
        text = page.run(f"extricate.controls.go({percent}); {DRAWN}")
        expect(tuple(word in text for word in words) == said, f"at {percent} % the panel says of the picture: {text}")
    text = page.run(f"extricate.stage.showLayer('ghost', false); extricate.controls.show(); {DRAWN}")
    expect("ghost" not in text, f"without ghosts the panel says of the picture: {text}")
    page.run("extricate.stage.showLayer('ghost', true); extricate.controls.show()")
    upright, level = page.run(AXES)
    expect(re.search(r"distance of the nearest pair, from .*m to .*m", upright), f"the vertical axis is labelled {upright}")
    expect(level == ["0 %", "share of the straight segment", "100 %"], f"the horizontal axis is labelled {level}")


def check_copies(page: chromium.Browser) -> None:
    page.run("navigator.clipboard.writeText = async text => { window.copied = text; }; extricate.controls.pick(0)")
    witness = page.run("extricate.controls.shown.exits[0].witness")
    texts = {}
    for button in page.run("[...document.querySelectorAll('#joints button')].map(button => button.textContent)"):
        page.run(f"[...document.querySelectorAll('#joints button')].find(button => button.textContent === {json.dumps(button)}).click()")
        texts[button] = page.run("window.copied")
    names = page.run("extricate.data.scene.joints.map(joint => joint.name)")
    expect(json.loads(texts["JSON"]) == witness, f"copied as JSON: {texts['JSON']}")
    expect(json.loads(texts["NumPy"].removeprefix("np.array(").removesuffix(")")) == witness, f"copied for NumPy: {texts['NumPy']}")
    lines = dict(line.split(": ", 1) for line in texts["JointState"].splitlines())
    expect([json.loads(lines["name"]), json.loads(lines["position"])] == [names, witness], f"copied as JointState: {texts['JointState']}")


def check_link(page: chromium.Browser, address: str) -> None:
    """Checks that a link leads to the same query, exit, place and view, and that the picture can be saved."""
    page.run("extricate.controls.choose(2); extricate.controls.go(40); extricate.stage.lookFrom(1, 0.3, 2)")
    page.run("[...document.querySelectorAll('#tools button')].find(button => button.textContent === 'copy link').click()")
    # Links hold five digits of the view.
    state = "[extricate.controls.query, extricate.controls.exit, extricate.controls.percent, ...extricate.stage.camera.position.toArray()]"
    before, link = page.run(state), page.run("window.copied")
    expect(link.startswith(f"{address}#q=3&e=1&t=40&c="), f"the link is {link}")
    page.open("about:blank")
    page.open(link)
    page.run(SETTLE)
    after = page.run(state)
    expect(all(abs(x - y) < 1e-4 for x, y in zip(after, before)), f"the link {link} shows {after}, expected {before}")
    saved = page.run("""new Promise(done => {
        HTMLAnchorElement.prototype.click = function () { done([this.download, this.href.slice(0, 22), this.href.length]); };
        [...document.querySelectorAll("#tools button")].find(button => button.textContent === "save picture").click();
    })""")
    expect(saved[0].endswith(".png") and saved[1] == "data:image/png;base64," and saved[2] > 10_000, f"the picture is saved as {saved}")


# Colours as people see them who lack one kind of cone: Machado, Oliveira, Fernandes, A Physiologically-based Model for Simulation of Color
# Vision Deficiency (2009), doi:10.1109/TVCG.2009.113, severity 1, applied to linear red, green and blue.
EYES = {
    "usual": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "tritanopia": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}
TO_XYZ = ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))
WHITE = (0.9505, 1.0, 1.089)


def lab(colour: int, eye: str) -> list[float]:
    """Returns a colour of sRGB in the space CIELAB, in which distances are differences that people see."""
    parts = [(colour >> shift & 255) / 255 for shift in (16, 8, 0)]
    linear = [x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    seen = [min(1.0, max(0.0, sum(a * x for a, x in zip(row, linear)))) for row in EYES[eye]]
    xyz = [sum(a * x for a, x in zip(row, seen)) / white for row, white in zip(TO_XYZ, WHITE)]
    f = [x ** (1 / 3) if x > 0.008856 else 7.787 * x + 16 / 116 for x in xyz]
    return [116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])]


def check_colours(palettes: list[dict[str, Any]]) -> float:
    """Checks that colours with different meanings differ for every eye; returns the least difference."""
    least = float("inf")
    for palette, eye in itertools.product(palettes, EYES):
        for a, b in itertools.combinations(("hit", "free", "plain", "obstacle", "back"), 2):
            difference = sum((x - y) ** 2 for x, y in zip(lab(palette[a], eye), lab(palette[b], eye))) ** 0.5
            least = min(least, difference)
            expect(difference >= LEAST_DIFFERENCE, f"{eye}: {a} and {b} differ by {difference:.1f}, at least {LEAST_DIFFERENCE}")
    return least
