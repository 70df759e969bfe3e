#!/usr/bin/env python3
"""Opens pages of `extricate view` in Chromium and looks at them as a user does.

    python3 scripts/check-view.py PROGRAM [--native NATIVE] [--live WASM NATIVE] [--robots FOLDER] [--site FOLDER] [--pictures FOLDER]

Where there is no Chromium, it says so and ends with status 0. What has to hold of every page:

- it opens from `file://` without an error on the console, and asks no network for anything;
- the first picture is there soon: the time on the clock is told, the processor time is held to a limit, as computers that
  check are busy;
- pictures at 0, 50 and 100 % of the slider differ, and show a robot, in the colour of collisions at 0 and of freedom at 100;
- every number is that of `query --json`, to the last digit, for every query and exit;
- keys do what they say; names with markup in them are text; a page of 20 queries has at most 1.2 MB;
- in the built-in scenes links that collide are seen, and no text is cut at 1,400, 800 and 390 pixels; the keyboard reaches
  everything; colours differ for people who lack a kind of cone; links and copies hold what is shown;
- the panel says what is proved, what arrows, ghosts and colours mean, what the axes of plots are, and how many balls are left out;
- frames of a motion, paths and grasps play back, and their numbers are those of the program.

With --native, NATIVE is the example `native` of extricate-wasm, which stands for the library in live pages: they play paths and
grasps, a waypoint that is dragged changes the path, and how long a step of dragging takes with the picture, and each of its parts,
is told.

With --live, WASM is what scripts/build-wasm.sh made. Then, of a live page with
a model of 100,000 labels, and of one in another world than the one that was learned:

- it has at most 4 MB;
- after 20 moves of joints and 20 of obstacles, every reply of the WebAssembly is that of the library, byte for byte;
- a step of dragging, from the moved slider to the numbers and the slice, takes at most 33 ms in the median. How long one takes
  with the picture drawn by software is told.

With --robots, FOLDER is where scripts/fetch-robots.py put robots: a page of the Panda with 20 queries has at most 1.2 MB too. With
--site, FOLDER is the documentation as mkdocs built it: its first page shows the live page of the demo.
"""
from __future__ import annotations

import argparse
import functools
import http.server
import json
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))
import chromium  # noqa: E402
from view_answers import check_scenes  # noqa: E402
from view_live import check_live, check_native  # noqa: E402
from view_pages import Program, check_clean, check_keys, check_numbers, check_pictures, check_words, expect, opened  # noqa: E402
from view_play import check_grasps, check_motion, check_paths  # noqa: E402

# Processor time of all of Chromium, with software rendering, from a blank page to the first picture [s].
MOST_BYTES, MOST_SECONDS, QUERIES = 1_200_000, 4.0, 20


def check_arm(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    extricate.run("demo --export cell")
    scene, options = "cell/shelf-arm.toml", "--input q.jsonl --exits 3"
    (extricate.folder / "q.jsonl").write_text(extricate.run(f"sample {scene} -n {QUERIES} --colliding --seed 1"))
    extricate.run(f"view {scene} {options} -o page.html")
    path = extricate.folder / "page.html"
    expect(path.stat().st_size <= MOST_BYTES, f"the page has {path.stat().st_size} bytes, at most {MOST_BYTES}")
    # Who wants no motion sees no opening, which would count as a part of the first picture.
    page.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
    before = page.processor_seconds()
    page.open(path.as_uri())
    # The second frame after a draw request begins once the first is drawn.
    drawn = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now()))))"
    seconds, busy = page.run(drawn) / 1000, page.processor_seconds() - before
    page.ask("Emulation.setEmulatedMedia", features=[])
    expect(page.run("!extricate.controls.isOpening"), "the page moves for people who want no motion")
    expect(busy < MOST_SECONDS, f"the first picture took {busy:.2f} s of processor time")
    check_pictures(page, pictures, "arm")
    compared = check_numbers(page, extricate.rows(f"query {scene} {options} --json"))
    check_keys(page)
    check_words(page)
    page.size(390, 844, touch=True)
    page.run("extricate.controls.go(40)")
    page.picture(pictures / "arm-phone.png")
    expect(page.run("document.documentElement.scrollWidth") <= 390, "the page is wider than a phone")
    page.size(1400, 900)
    check_clean(page, "arm", path.as_uri())
    print(f"arm: {QUERIES} queries, {path.stat().st_size / 1e6:.2f} MB, first picture after {seconds:.2f} s, {busy:.2f} s of processor time, {compared} numbers equal")


def check_answers(page: chromium.Browser, extricate: Program) -> None:
    """Checks that answers of a file are shown in place of new ones."""
    scene = "cell/shelf-arm.toml"
    (extricate.folder / "a.jsonl").write_text(extricate.run(f"query {scene} --input q.jsonl --effort exhaustive --exits 2 --json"))
    extricate.run(f"view {scene} --input q.jsonl --answers a.jsonl -o page.html")
    page.open((extricate.folder / "page.html").as_uri())
    rows = [json.loads(text) for text in (extricate.folder / "a.jsonl").read_text().splitlines()]
    print(f"answers of a file: {check_numbers(page, rows)} numbers equal")
    check_clean(page, "answers", (extricate.folder / "page.html").as_uri())


HOSTILE = """<robot name="r"><link name="base"/><link name="&lt;img src=x onerror=alert(1)&gt;&lt;/script&gt;"><collision>
<origin xyz="0.25 0 0"/><geometry><box size="0.5 0.05 0.05"/></geometry></collision></link>
<joint name="&lt;b&gt;turn" type="continuous"><parent link="base"/><child link="&lt;img src=x onerror=alert(1)&gt;&lt;/script&gt;"/><axis xyz="0 0 1"/></joint></robot>"""


def check_names(page: chromium.Browser, extricate: Program) -> None:
    (extricate.folder / "r.urdf").write_text(HOSTILE)
    scene = '[[robot]]\nurdf = "r.urdf"\n[[obstacle]]\nname = "</script><b>post"\nshape = { cylinder = [0.1, 0.5] }\npose = { xyz = [0.4, 0.1, 0] }\n'
    (extricate.folder / "hostile.toml").write_text(scene)
    extricate.run("view hostile.toml --q 0 --q 3 -o page.html")
    page.open((extricate.folder / "page.html").as_uri())
    check_clean(page, "names", (extricate.folder / "page.html").as_uri())
    text = page.run("document.body.innerText")
    expect("</script><b>post" in text and "<b>turn" in text, "names with markup are not shown as they are")
    expect(page.run("document.querySelectorAll('#panel img, #panel b.x').length") == 0, "a name has become markup")
    expect(page.run("extricate.controls.shown.slice") is None, "one joint has no plane")
    page.run("extricate.controls.choose(1)")
    expect("is free" in page.run("document.querySelector('#numbers').innerText"), "a free query is not told")


def check_robot(page: chromium.Browser, extricate: Program, robots: Path, pictures: Path) -> None:
    """Checks a page of the Panda beside a box, with its meshes."""
    urdf = robots.resolve() / "example-robot-data/robots/panda_description/urdf/panda.urdf"
    scene = f'[[robot]]\nurdf = "{urdf}"\npackages = ["{robots.resolve()}"]\n'
    scene += '[[obstacle]]\nname = "box"\nshape = { box = [0.3, 0.4, 0.5] }\npose = { xyz = [0.5, 0, 0.3] }\n'
    (extricate.folder / "panda.toml").write_text(scene)
    address = opened(page, extricate, f"panda.toml -n {QUERIES}")
    size = (extricate.folder / "page.html").stat().st_size
    expect(size <= MOST_BYTES, f"the page of the Panda has {size} bytes, at most {MOST_BYTES}")
    check_pictures(page, pictures, "panda")
    check_clean(page, "panda", address)
    print(f"panda: {QUERIES} queries, {size / 1e6:.2f} MB")


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves files of a folder without logging."""

    def log_message(self, *_: Any) -> None:
        pass


def check_site(page: chromium.Browser, site: Path) -> None:
    """Checks that the first page of the documentation holds the live page of the demo, and runs it."""
    handler = functools.partial(Quiet, directory=str(site.resolve()))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f"http://127.0.0.1:{server.server_address[1]}/"
        page.open(f"{address}index.html")
        depth = page.run("""new Promise(done => {
            const inside = document.querySelector("iframe").contentWindow;
            const wait = () => inside.extricate && inside.extricate.live ? done(inside.extricate.live.controls.shown.answer.depth) : setTimeout(wait, 50);
            wait();
        })""")
        server.shutdown()
    expect(depth > 0, f"the demo of the first page has depth {depth}")
    expect(not page.errors, f"site: errors on the console: {page.errors}")
    asked = [url for url in page.requests if not url.startswith((address, "data:", "blob:"))]
    expect(not asked, f"site: the first page asks for {asked}")
    print(f"site: the first page runs the live demo, depth {depth:.4f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--native", type=Path, metavar="NATIVE")
    parser.add_argument("--live", nargs=2, type=Path, metavar=("WASM", "NATIVE"))
    parser.add_argument("--robots", type=Path, metavar="FOLDER")
    parser.add_argument("--site", type=Path, metavar="FOLDER")
    parser.add_argument("--pictures", type=Path)
    given = parser.parse_args()
    browser = chromium.find()
    if browser is None:
        print("PAGES NOT CHECKED: there is no Chromium here (Debian: apt-get install chromium)")
        return
    with tempfile.TemporaryDirectory() as folder, chromium.Browser(browser) as page:
        pictures = given.pictures or Path(folder)
        pictures.mkdir(parents=True, exist_ok=True)
        extricate = Program(str(given.program), Path(folder))
        check_arm(page, extricate, pictures)
        check_scenes(page, extricate, pictures)
        check_answers(page, extricate)
        check_names(page, extricate)
        check_motion(page, extricate, pictures)
        check_paths(page, extricate, pictures)
        check_grasps(page, extricate, pictures)
        if given.native:
            check_native(page, extricate, given.native, pictures)
        if given.live:
            check_live(page, extricate, *given.live, pictures)
        if given.robots:
            check_robot(page, extricate, given.robots, pictures)
        if given.site:
            check_site(page, given.site)
    print("pages: all passed")


if __name__ == "__main__":
    main()
