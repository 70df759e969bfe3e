"""Checks of live pages: the library in the page, compared with the native one. Called by check-view.py."""
from __future__ import annotations

import base64
import json
import statistics
import subprocess
from pathlib import Path

import chromium
from view_pages import Program, check_clean, expect

MOST_LIVE_BYTES, LABELS, MOVES, MOST_STEP = 4_000_000, 100_000, 20, 33.0
# Records requests to the library and its replies.
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
    return [performance.now() - began, !!extricate.controls.shown.slice];
})()"""
PUSH = """(() => {
    const { live } = extricate;
    live.push(live.obstacles[%d %% live.obstacles.length], [%r, %r, %r]);
    cancelAnimationFrame(live.due);
    live.due = null;
    live.ask(live.wanted, live.cells);
})()"""


# One step of dragging, until the picture is drawn too.
TURN_DRAWN = TURN.replace("return [", """const { stage } = extricate, gl = stage.renderer.getContext();
    stage.drawAt(false);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    return [""")


def check_live(page: chromium.Browser, extricate: Program, wasm: Path, native: Path, pictures: Path) -> None:
    folder = extricate.folder
    extricate.run(f"learn cell/shelf-arm.toml -o arm.model --labels {LABELS} --seed 1")
    # The same cell with a box beside the arm, which the model does not know.
    world = (folder / "cell/shelf-arm.toml").read_text()
    box = '\n[[obstacle]]\nname = "parcel"\nshape = { box = [0.2, 0.2, 0.2] }\npose = { xyz = [0.45, 0.35, 0.5] }\n'
    (folder / "cell/other.toml").write_text(world + box)
    for name, line in (("live", "arm.model"), ("live in another world", "arm.model --world cell/other.toml")):
        extricate.run(f"view {line} -n 2 --live --wasm {wasm.resolve()} -o live.html")
        check_live_page(page, name, folder, native, pictures)


def check_live_page(page: chromium.Browser, name: str, folder: Path, native: Path, pictures: Path) -> None:
    path = folder / "live.html"
    expect(path.stat().st_size <= MOST_LIVE_BYTES, f"{name}: the page has {path.stat().st_size} bytes, at most {MOST_LIVE_BYTES}")
    page.open(path.as_uri())
    page.run("new Promise(done => { const wait = () => extricate.liveReady ? done() : setTimeout(wait, 50); wait(); })")
    check_clean(page, name, path.as_uri())
    ready = page.run("extricate.liveReady") / 1000
    page.run(RECORD)
    step, drawn = (dragged(page, name, turn) for turn in (TURN, TURN_DRAWN))
    for at in range(MOVES):
        page.run(PUSH % (at, 0.01 * (at % 3 - 1), 0.013 * (at % 4 - 1.5), 0.004 * (at % 2)))
    page.picture(pictures / f"{name.replace(' ', '-')}.png")
    recorded = page.run("recorded")
    expect(len(recorded) >= 4 * MOVES, f"{name}: {len(recorded)} requests were made")
    depths = check_replies(page, name, folder, native, recorded)
    expect(len(depths) > MOVES // 2, f"{name}: only {len(depths)} depths were seen")
    shown = page.run("Number(document.querySelector('#numbers [data-key=depth]').dataset.value)")
    expect(shown == json.loads(recorded[-1][1])["answer"]["depth"], f"{name}: the page does not show what the library replied")
    check_left(page, name)
    check_clean(page, name, path.as_uri())
    expect(step <= MOST_STEP, f"{name}: a step takes {step:.1f} ms in the median, at most {MOST_STEP}")
    print(f"{name}: {path.stat().st_size / 1e6:.2f} MB, dragging after {ready:.2f} s, {len(recorded)} replies equal byte for byte; a step with "
          f"a slice of {page.run('extricate.live.cells')} cells takes {step:.1f} ms in the median, {drawn:.1f} ms with "
          "the picture drawn by software")


def check_left(page: chromium.Browser, name: str) -> None:
    """Checks that dragging one query does not change another that is shown meanwhile."""
    other = page.run("extricate.controls.answers[1].q")
    page.run("extricate.live.want(extricate.controls.shown.q); extricate.controls.choose(1)")
    page.run("new Promise(done => setTimeout(done, 700))")
    expect(page.run("extricate.controls.shown.q") == other, f"{name}: what was dragged of one query is shown of another")


def dragged(page: chromium.Browser, name: str, turn: str) -> float:
    """Returns the median time of a step [ms], over those of 20 that show a slice."""
    page.run("window.first = window.first || extricate.controls.shown.q; extricate.live.ask(first, extricate.live.cells)")
    steps = [page.run(turn % (at, 0.01 * (at % 5 - 1.5))) for at in range(MOVES)]
    times = [time for time, has_slice in steps if has_slice]
    expect(len(times) > MOVES // 2, f"{name}: only {len(times)} of {MOVES} steps show a slice")
    return statistics.median(times)


def check_replies(page: chromium.Browser, name: str, folder: Path, native: Path, recorded: list[list[str]]) -> set[float]:
    """Checks that every reply is that of the native library; returns the depths in them."""
    files = []
    for key in ("scene", "world"):
        if held := page.run(f"extricate.data.live.{key} || ''"):
            (folder / key).write_bytes(base64.b64decode(held))
            files.append(key)
    expect(("world" in files) == ("world" in name), f"{name}: the page holds {files}")
    asked = "".join(f"{request}\n" for request, _ in recorded)
    done = subprocess.run([str(native.resolve()), *files], cwd=folder, input=asked, capture_output=True, text=True)
    expect(done.returncode == 0, f"native: {done.stderr}")
    replies = done.stdout.splitlines()
    expect(len(replies) == len(recorded), f"native: {len(replies)} replies to {len(recorded)} requests")
    for number, ((request, reply), expected) in enumerate(zip(recorded, replies)):
        expect(reply == expected, f"request {number + 1}, {request}: the page has {reply[:300]}, the library {expected[:300]}")
    return {depth for _, reply in recorded if (depth := json.loads(reply).get("answer", {}).get("depth")) is not None}
