#!/usr/bin/env python3
"""Opens pages of `extricate view` in Chromium and looks at them as a user does.

    python3 scripts/check-view.py PROGRAM [--live WASM NATIVE] [--pictures FOLDER]

Where there is no Chromium, it says so and ends with status 0. What has to hold of every page:

- it opens from `file://` without an error on the console, and asks no network for anything;
- the first picture is there soon: the time on the clock is told, the processor time is held to a limit, as computers that
  check are busy;
- pictures at 0, 50 and 100 % of the slider differ, and show a robot, in the colour of collisions at 0 and of freedom at 100;
- every number is that of `query --json`, to the last digit, for every query and exit;
- keys do what they say; names with markup in them are text; a page of 20 queries has at most 1.5 MB.

With --live, WASM is what scripts/build-wasm.sh made and NATIVE the example `native` of extricate-wasm. Then, of a live page with
a model of 100,000 labels:

- it has at most 4 MB, and dragging begins within the same limits;
- after 20 moves of joints and 20 of obstacles, every reply of the WebAssembly is that of the library, byte for byte;
- how long a step of dragging with its slice takes is told.
"""
from __future__ import annotations

import argparse
import base64
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent))
import chromium  # noqa: E402

# Processor time of all of Chromium, with software rendering, from a blank page to the first picture [s].
MOST_BYTES, MOST_SECONDS, QUERIES = 1_500_000, 4.0, 20
# Of the canvas, how many pixels are of the hue of collisions, of freedom, and of no background.
PIXELS = """(() => {
    const from = extricate.stage.renderer.domElement, to = document.createElement("canvas");
    extricate.stage.draw();
    to.width = from.width; to.height = from.height;
    const context = to.getContext("2d");
    context.drawImage(from, 0, 0);
    const data = context.getImageData(0, 0, to.width, to.height).data;
    let hit = 0, free = 0, drawn = 0, sum = 0;
    for (let at = 0; at < data.length; at += 4) {
        const [r, g, b] = [data[at], data[at + 1], data[at + 2]];
        if (r > 1.5 * g && g > 1.3 * b) hit++;
        if (b > 1.25 * g && g > 1.4 * r) free++;
        if (Math.abs(r - 238) + Math.abs(g - 241) + Math.abs(b - 245) > 60) drawn++;
        sum = (31 * sum + r + 3 * g + 7 * b) % 4294967296;
    }
    return { hit, free, drawn, sum };
})()"""
NUMBERS = """Object.fromEntries([...document.querySelectorAll("#numbers [data-key]")]
    .map(found => [found.dataset.key, found.dataset.value]))"""
JOINTS = """["query", "exit"].map(key => [...document.querySelectorAll(`#joints [data-joint=${key}]`)]
    .map(cell => Number(cell.dataset.value)))"""


def expect(holds: object, text: str) -> None:
    if not holds:
        raise AssertionError(text)


def go(page: chromium.Browser, percent: int) -> Any:
    page.run(f"extricate.controls.go({percent})")
    return page.run(PIXELS)


def check_pictures(page: chromium.Browser, folder: Path, name: str) -> None:
    seen = []
    for percent in (0, 50, 100):
        pixels = go(page, percent)
        page.picture(folder / f"{name}-{percent}.png")
        expect(pixels["drawn"] > 5000, f"{name} at {percent} %: the picture is empty: {pixels}")
        seen.append(pixels)
    expect(len({pixels["sum"] for pixels in seen}) == 3, f"{name}: pictures along the slider are the same: {seen}")
    expect(seen[0]["hit"] > 200, f"{name}: nothing is in the colour of collisions at the query: {seen[0]}")
    expect(seen[2]["free"] > 1000 and seen[2]["free"] > 4 * seen[0]["free"], f"{name}: the exit is not shown as free: {seen}")


def check_numbers(page: chromium.Browser, rows: list[dict[str, Any]]) -> int:
    """Compares what the page says with lines of `query --json`; gives how many numbers were compared."""
    compared = 0
    for at, row in enumerate(rows):
        page.run(f"extricate.controls.choose({at})")
        shown = page.run(NUMBERS)
        names = ["depth", "lower_bound", "gap", "max_displacement", "verified", "clearance", "unique", "checks", "effort"]
        names += [name for name in ("coverage", "unseen") if row[name] is not None]
        for name in names:
            value = json.loads(shown[name]) if name != "effort" else shown[name]
            expect(value == row[name], f"query {at + 1}: {name}: the page has {value}, the program {row[name]}")
        for name in ("colliding", "touching"):
            expect(json.loads(shown[name]) == row[name], f"query {at + 1}: {name}: {shown[name]} {row[name]}")
        for number, found in enumerate(row.get("exits", [])):
            page.run(f"extricate.controls.pick({number})")
            _, witness = page.run(JOINTS)
            expect(witness == found["witness"], f"query {at + 1}, exit {number + 1}: {witness} {found['witness']}")
            shown = page.run(NUMBERS)
            depth = json.loads(shown["exit_depth" if number else "depth"])
            expect(depth == found["depth"], f"query {at + 1}, exit {number + 1}: {depth} {found['depth']}")
            compared += 1 + len(witness)
        compared += len(names) + 2
    return compared


def check_keys(page: chromium.Browser) -> None:
    page.run("extricate.controls.choose(0); extricate.controls.go(0); document.activeElement.blur()")
    state = "[extricate.controls.query, extricate.controls.exit, extricate.controls.percent]"
    for keys, expected in ((["ArrowRight"] * 3, [0, 0, 3]), (["End"], [0, 0, 100]), (["Home"], [0, 0, 0]), (["n"], [1, 0, 0]), (["p"], [0, 0, 0])):
        for key in keys:
            page.press(key)
        found = page.run(state)
        expect(found == expected, f"after {keys}: got {found}, expected {expected}")


def check_words(page: chromium.Browser) -> None:
    unexplained = page.run("""[...document.querySelectorAll("#numbers .word")].filter(word => !word.title).map(word => word.textContent)""")
    expect(not unexplained, f"words that the page does not explain: {unexplained}")
    page.run("document.querySelector('#numbers .word').click()")
    expect(page.run("document.querySelectorAll('#numbers .meaning').length") == 1, "a word that is pressed does not say what it means")


def check_clean(page: chromium.Browser, name: str, address: str) -> None:
    expect(not page.errors, f"{name}: errors on the console: {page.errors}")
    asked = [url for url in page.requests if url != address and not url.startswith(("data:", "blob:"))]
    expect(not asked, f"{name}: the page asks for {asked}")


class Program:
    """The command line, in a folder."""

    def __init__(self, program: str, folder: Path) -> None:
        self.program, self.folder = str(Path(program).resolve()), folder

    def run(self, line: str) -> str:
        done = subprocess.run([self.program, *line.split()], cwd=self.folder, capture_output=True, text=True)
        expect(done.returncode == 0, f"extricate {line}: {done.stderr}")
        return done.stdout

    def rows(self, line: str) -> list[dict[str, Any]]:
        return [json.loads(text) for text in self.run(line).splitlines()]


def check_arm(page: chromium.Browser, extricate: Program, pictures: Path) -> None:
    extricate.run("demo --export cell")
    scene, options = "cell/shelf-arm.toml", "--input q.jsonl --exits 3"
    (extricate.folder / "q.jsonl").write_text(extricate.run(f"sample {scene} -n {QUERIES} --colliding --seed 1"))
    extricate.run(f"view {scene} {options} -o page.html")
    path = extricate.folder / "page.html"
    expect(path.stat().st_size <= MOST_BYTES, f"the page has {path.stat().st_size} bytes, at most {MOST_BYTES}")
    before = page.processor_seconds()
    page.open(path.as_uri())
    seconds, busy = page.run("extricate.ready") / 1000, page.processor_seconds() - before
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
    """Answers of a file are shown in place of new ones."""
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


MOST_LIVE_BYTES, LABELS, MOVES = 4_000_000, 100_000, 20
# Records what the library is asked and what it replies.
RECORD = """(() => {
    const library = extricate.live.library, call = library.call.bind(library);
    window.recorded = [];
    library.call = request => {
        const reply = call(request);
        recorded.push([JSON.stringify(request), reply]);
        return reply;
    };
})()"""
# One step of dragging, as soon as the page would take it.
TURN = """(() => {
    const { live } = extricate, slider = live.sliders[%d %% live.sliders.length];
    slider.input.value = String(Number(slider.input.value) + %r * (slider.high - slider.low));
    const began = performance.now();
    slider.input.dispatchEvent(new Event("input"));
    cancelAnimationFrame(live.due);
    live.due = null;
    live.ask(live.wanted, live.cells);
    return performance.now() - began;
})()"""
PUSH = """(() => {
    const { live } = extricate;
    live.push(live.obstacles[%d %% live.obstacles.length], [%r, %r, %r]);
    cancelAnimationFrame(live.due);
    live.due = null;
    live.ask(live.wanted, live.cells);
})()"""


def check_live(page: chromium.Browser, extricate: Program, wasm: Path, native: Path, pictures: Path) -> None:
    folder = extricate.folder
    extricate.run(f"learn cell/shelf-arm.toml -o arm.model --labels {LABELS} --seed 1")
    extricate.run(f"view arm.model -n 2 --live --wasm {wasm.resolve()} -o live.html")
    path = folder / "live.html"
    expect(path.stat().st_size <= MOST_LIVE_BYTES, f"the live page has {path.stat().st_size} bytes, at most {MOST_LIVE_BYTES}")
    page.open(path.as_uri())
    page.run("new Promise(done => { const wait = () => extricate.liveReady ? done() : setTimeout(wait, 50); wait(); })")
    check_clean(page, "live", path.as_uri())
    ready = page.run("extricate.liveReady") / 1000
    page.run(RECORD)
    times = [page.run(TURN % (at, 0.01 * (at % 5 - 1.5))) for at in range(MOVES)]
    for at in range(MOVES):
        page.run(PUSH % (at, 0.01 * (at % 3 - 1), 0.013 * (at % 4 - 1.5), 0.004 * (at % 2)))
    page.picture(pictures / "live.png")
    recorded = page.run("recorded")
    expect(len(recorded) >= 3 * MOVES, f"{len(recorded)} requests were made")
    (folder / "opened").write_bytes(base64.b64decode(page.run("extricate.data.live.scene")))
    asked = "".join(f"{request}\n" for request, _ in recorded)
    done = subprocess.run([str(native.resolve()), "opened"], cwd=folder, input=asked, capture_output=True, text=True)
    expect(done.returncode == 0, f"native: {done.stderr}")
    depths = set()
    replies = done.stdout.splitlines()
    expect(len(replies) == len(recorded), f"native: {len(replies)} replies to {len(recorded)} requests")
    for number, ((request, reply), expected) in enumerate(zip(recorded, replies)):
        expect(reply == expected, f"request {number + 1}, {request}: the page has {reply[:300]}, the library {expected[:300]}")
        depths.add(json.loads(reply).get("answer", {}).get("depth"))
    expect(len(depths) > MOVES // 2, f"only {len(depths)} depths were seen")
    shown = page.run("Number(document.querySelector('#numbers [data-key=depth]').dataset.value)")
    expect(shown == json.loads(recorded[-1][1])["answer"]["depth"], "the page does not show what the library replied")
    check_clean(page, "live", path.as_uri())
    print(f"live: {path.stat().st_size / 1e6:.2f} MB, dragging after {ready:.2f} s, {len(recorded)} replies equal byte for byte; a step with "
          f"a slice of {page.run('extricate.live.cells')} cells takes {statistics.median(times):.1f} ms in the median, software rendering beside it")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--live", nargs=2, type=Path, metavar=("WASM", "NATIVE"))
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
        check_answers(page, extricate)
        check_names(page, extricate)
        if given.live:
            check_live(page, extricate, *given.live, pictures)
    print("pages: all passed")


if __name__ == "__main__":
    main()
