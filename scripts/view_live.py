"""Checks of live pages: the library in the page, compared with the native one. Called by check-view.py."""
from __future__ import annotations

import base64
import contextlib
import http.server
import json
import statistics
import subprocess
import threading
from pathlib import Path
from typing import Any, Iterator

import chromium
from view_pages import Program, check_clean, expect
from view_play import WATCH

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


# One step of dragging, until the picture is drawn too; also how long the library took, how long the browser was still busy with the
# page of the step before, and how long the picture took.
TURN_DRAWN = TURN.replace("return [", """const { stage } = extricate, gl = stage.renderer.getContext();
    const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    const asked = performance.now();
    finish();
    const idle = performance.now();
    stage.drawAt(false);
    finish();
    const split = [window.library_time, idle - asked, performance.now() - idle];
    return [""").replace("slice];", "slice, ...split];")
# Keeps the time of the last call of the library.
TIMED = """(() => {
    const { library } = extricate.live, call = library.call.bind(library);
    library.call = request => {
        const began = performance.now(), reply = call(request);
        window.library_time = performance.now() - began;
        return reply;
    };
})()"""
READY = "new Promise(done => { const wait = () => extricate.liveReady ? done() : setTimeout(wait, 50); wait(); })"
# In place of the library as WebAssembly: the native one, asked over HTTP.
BRIDGE = """WebAssembly.instantiate = async () => {
    const memory = { buffer: new ArrayBuffer(16 << 20) };
    let asked = 0, replied = 0;
    const extricate_call = () => {
        const request = new XMLHttpRequest();
        request.open("POST", %r, false);
        request.send(new Uint8Array(memory.buffer, 0, asked).slice());
        const bytes = new TextEncoder().encode(request.responseText);
        new Uint8Array(memory.buffer).set(bytes);
        replied = bytes.length;
        return 0;
    };
    return { instance: { exports: {
        memory, extricate_call, extricate_open: () => 0, extricate_enter: () => 0, extricate_input: length => { asked = length; return 0; },
        extricate_output: () => 0, extricate_output_length: () => replied,
    } } };
};"""


@contextlib.contextmanager
def bridged(page: chromium.Browser, extricate: Program, native: Path, line: str) -> Iterator[None]:
    """Opens a live page of `extricate view LINE` whose library is the native one."""
    folder = extricate.folder
    (folder / "stub.wasm").write_bytes(b"\0asm")
    extricate.run(f"view {line} --live --wasm stub.wasm -o live.html")
    text = (folder / "live.html").read_text().split('id="data">')[1].split("</script>")[0]
    (folder / "opened").write_bytes(base64.b64decode(json.loads(text)["live"]["scene"]))
    with subprocess.Popen([str(native.resolve()), "opened"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as library:

        class Asked(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            # Otherwise the reply waits 40 ms until the browser has confirmed the header.
            disable_nagle_algorithm = True

            def do_POST(self) -> None:  # noqa: N802
                library.stdin.write(self.rfile.read(int(self.headers["Content-Length"])) + b"\n")
                library.stdin.flush()
                reply = library.stdout.readline()
                self.send_response(200)
                self.send_header("Access-Control-Allow-Origin", "*")
                self.send_header("Content-Length", str(len(reply)))
                self.end_headers()
                self.wfile.write(reply)

            def log_message(self, *_: Any) -> None:
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Asked) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            source = BRIDGE % f"http://127.0.0.1:{server.server_address[1]}/"
            script = page.ask("Page.addScriptToEvaluateOnNewDocument", source=source)["identifier"]
            # The page itself may ask no network for anything.
            page.ask("Page.setBypassCSP", enabled=True)
            page.open((folder / "live.html").as_uri())
            page.run(READY)
            yield
            page.ask("Page.setBypassCSP", enabled=False)
            page.ask("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
            page.open("about:blank")
            server.shutdown()
        library.stdin.close()


def check_native(page: chromium.Browser, extricate: Program, native: Path, pictures: Path) -> None:
    """Checks live pages with the native library in the place of the WebAssembly: what they play, and how long a step takes."""
    folder = extricate.folder
    with bridged(page, extricate, native, "cell/shelf-arm.toml --paths paths.jsonl"):
        page.run(RECORD)
        before = page.run("extricate.controls.go(34); extricate.controls.shown.exits[0].way.map(point => point.q)")
        page.run(TURN % (1, 0.02))
        shown = page.run("extricate.controls.shown")
        after = [point["q"] for point in shown["exits"][0]["way"]]
        moved = [sum(a != b for a, b in zip(*points)) for points in zip(before, after)]
        expect(sorted(moved) == [0] * (len(moved) - 1) + [1], f"live path: a drag changed {moved} coordinates of the waypoints")
        at = shown["exits"][0]["way"][moved.index(1)]["at"]
        expect(abs(page.run("extricate.controls.percent") - 100 * at) < 1e-9, "live path: the slider is not at the waypoint that is dragged")
        path = shown["played"]["path"]
        expect(len(page.run("[...document.querySelectorAll('#proved i')]")) == path["waypoints"] - 1, f"live path: the strip does not show {path}")
        expect(json.loads(page.run("recorded")[-1][1]) == shown, "live path: the page does not show what the library replied")
        page.picture(pictures / "live-path.png")
        page.run("extricate.live.forget(); extricate.controls.choose(0); document.activeElement.blur()")
        seen = page.run(WATCH)
        expect({at for at, _ in seen} == {0, 1} and seen[-1] == [1, 100], f"live paths were played as {seen[:3]} to {seen[-1]}")
        expect(not page.errors, f"live path: errors on the console: {page.errors}")
    with bridged(page, extricate, native, "grip.toml --input g.jsonl --answers a.jsonl"):
        expect("grasp" in page.run("document.getElementById('numbers').textContent"), "live grasp: it opens on something else")
        expect(len(page.run("extricate.controls.shown.exits[0].distances")) == 101, "live grasp: there is no plot")
        page.run(TURN % (0, -0.01))
        row, = extricate.rows(f"query grip.toml --q {','.join(map(repr, page.run('extricate.controls.shown.q')))} --exits 3 --json")
        expect(page.run("extricate.controls.shown.answer.depth") == row["depth"], "live grasp: what is dragged is not answered as a query")
        expect(not page.errors, f"live grasp: errors on the console: {page.errors}")
    for scene in ("shelf-arm", "hand"):
        if not (folder / scene).exists():
            extricate.run(f"demo --scene {scene} --export {scene}")
        with bridged(page, extricate, native, f"{scene}/{scene}.toml -n 2 --seed 1"):
            expect(page.run("extricate.controls.shown.exits[0].distances.length") == 101, f"live {scene}: there is no plot")
            page.run("window.first = extricate.controls.shown.q; extricate.live.ask(first, extricate.live.cells)")
            page.run(TIMED)
            steps = [page.run(TURN_DRAWN % (at, 0.01 * (at % 5 - 1.5))) for at in range(2 * MOVES)]
            times = sorted(step[0] for step in steps)
            library, waited, drawn = (statistics.median(step[at] for step in steps) for at in (2, 3, 4))
            calls, triangles = page.run("(({ calls, triangles }) => [calls, triangles])(extricate.stage.renderer.info.render)")
            print(f"live {scene}: a step of dragging with the picture, by the native library and drawn by software, takes "
                  f"{times[MOVES]:.1f} ms in the median, {times[int(1.9 * MOVES)]:.1f} ms at 95 %; medians of its parts: library {library:.1f}, "
                  f"page of the step before {waited:.1f}, picture {drawn:.1f} ms ({calls} draws, {triangles} triangles)")


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
    page.run(READY)
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
    times = [time for time, has_slice, *_ in steps if has_slice]
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
