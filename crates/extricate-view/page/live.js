// The library itself, in the page: joints and obstacles are moved, and the answer follows.

// Cells to each side of a slice; a step of dragging is to take as many milliseconds, so that some are left for the picture.
const LIVE_CELLS = { least: 24, most: 112, patience: 24 };

// What a gzip file holds, or the bytes themselves where they are none.
async function unpacked(text) {
    const bytes = new Uint8Array(bytesOf(text));
    if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Requests and replies of the library: JSON for JSON, so numbers keep all of their digits.
class Library {
    static async open({ program, scene, world }) {
        const { instance } = await WebAssembly.instantiate(await unpacked(program), {});
        const library = new Library();
        library.exports = instance.exports;
        library.send(await unpacked(scene), "extricate_open");
        if (world) library.send(await unpacked(world), "extricate_enter");
        return library;
    }

    send(bytes, name) {
        const at = this.exports.extricate_input(bytes.length);
        new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
        const failed = this.exports[name]();
        const [from, length] = [this.exports.extricate_output(), this.exports.extricate_output_length()];
        const reply = new TextDecoder().decode(new Uint8Array(this.exports.memory.buffer, from, length));
        if (failed) throw new Error(reply);
        return reply;
    }

    // The reply as text.
    call(request) {
        return this.send(new TextEncoder().encode(JSON.stringify(request)), "extricate_call");
    }
}

class Live {
    constructor(library, controls) {
        Object.assign(this, { library, controls, cells: 48, exits: 3, moved: {} });
        byId("live").hidden = false;
        this.makeJoints();
        this.makeObstacles();
        if (stage) this.followPointer();
        // What was dragged is of the query before.
        controls.onChoose = () => this.forget();
        const { show } = controls;
        controls.show = () => {
            show();
            this.showJoints();
        };
        this.showJoints();
    }

    // What is dragged: the waypoint of a path that is nearest to the slider, or the query.
    held() {
        const { shown, percent } = this.controls;
        const points = waypointsOf(shown);
        const off = points.map(({ at }) => Math.abs(100 * at - percent));
        const nearest = off.indexOf(Math.min(...off));
        return { points, nearest, q: points.length ? points[nearest].q : shown.q };
    }

    // One row a tangent coordinate: a turn about each axis for a rotation.
    makeJoints() {
        const body = element("tbody");
        this.sliders = SCENE.factors.flatMap(factor => {
            const { manifold, name, q } = factor;
            if (manifold === "Rotation") return ["x", "y", "z"].map(axis => ({ factor, name: `${name} ${axis}`, axis, low: -1, high: 1 }));
            const { lower, upper } = manifold === "Circle" ? { lower: -Math.PI, upper: Math.PI } : manifold.Interval;
            return [{ factor, name, q, low: lower, high: upper }];
        });
        for (const slider of this.sliders) {
            slider.input = element("input", { type: "range", min: String(slider.low), max: String(slider.high), step: "any" });
            slider.input.setAttribute("aria-label", slider.name);
            slider.text = element("td", { className: "n" });
            slider.input.oninput = () => this.turn(slider);
            body.append(element("tr", {}, element("td", {}, slider.name), element("td", {}, slider.input), slider.text));
        }
        byId("live").append(element("h2", {}, "Drag the joints, or the obstacles in the picture"), element("table", {}, body));
    }

    makeObstacles() {
        this.obstacles = SCENE.bodies.filter(body => body.seat);
        if (!this.obstacles.length) return;
        this.list = element("select", { "aria-label": "obstacle" });
        this.obstacles.forEach((body, at) => this.list.append(element("option", { value: String(at) }, body.name)));
        const steps = [["x", 0], ["y", 1], ["z", 2]].flatMap(([axis, k]) => [-1, 1].map(sign => {
            const button = element("button", { type: "button" }, (sign < 0 ? "\u2212" : "+") + axis);
            button.onclick = () => this.push(this.obstacles[Number(this.list.value)], [0, 1, 2].map(at => (at === k ? sign * this.step() : 0)));
            return button;
        }));
        this.note = element("small");
        byId("live").append(element("div", { className: "row" }, this.list, ...steps), this.note);
    }

    // How far a press moves an obstacle [m].
    step() {
        return stage ? stage.cell / 4 : 0.02;
    }

    turn(slider) {
        const q = this.held().q.slice();
        const { factor } = slider;
        if (slider.axis) {
            const turned = [0, 1, 2].map(k => Number(this.sliders.filter(other => other.factor === factor)[k].input.value) * Math.PI);
            const angle = Math.hypot(...turned);
            const [s, c] = [angle > 1e-12 ? Math.sin(angle / 2) / angle : 0.5, Math.cos(angle / 2)];
            [...turned.map(x => x * s), c].forEach((x, k) => { q[factor.q + k] = x; });
        } else {
            q[slider.q] = Number(slider.input.value);
        }
        this.want(q);
    }

    showJoints() {
        const { q } = this.held();
        if (q === this.isShown) return;
        this.isShown = q;
        for (const slider of this.sliders) {
            const { factor } = slider;
            let value = slider.axis ? 0 : q[slider.q];
            if (slider.axis) {
                const [x, y, z, w] = q.slice(factor.q, factor.q + 4);
                const [sine, sign] = [Math.hypot(x, y, z), w < 0 ? -1 : 1];
                const angle = 2 * Math.atan2(sine, Math.abs(w));
                value = sine > 0 ? sign * ({ x, y, z })[slider.axis] / sine * angle / Math.PI : 0;
            }
            if (document.activeElement !== slider.input) slider.input.value = String(value);
            slider.text.textContent = slider.axis ? fixed(value * 180, 1) + "\u00b0"
                : isAngle(slider.q) ? `${fixed(value, 3)} (${fixed(value * 180 / Math.PI, 1)}\u00b0)` : fixed(value, 4);
        }
    }

    // Asks at most once a frame, and once more in full when nothing changes any longer.
    want(q) {
        this.wanted = q;
        const { controls } = this;
        // What was played when the page opened ends at the exit; what is dragged is the query.
        if (controls.isOpening) controls.go(0);
        controls.stop();
        controls.player.stop();
        if (this.due) return;
        this.due = requestAnimationFrame(() => {
            this.due = null;
            this.ask(this.wanted, this.cells);
            // In this frame, not in the next one.
            if (stage) stage.drawAt(false);
        });
        clearTimeout(this.later);
        // Before the picture is at rest, so that it is drawn with smooth edges once.
        this.later = setTimeout(() => this.ask(this.wanted, LIVE_CELLS.most), 0.8 * REST);
    }

    forget() {
        cancelAnimationFrame(this.due);
        clearTimeout(this.later);
        this.due = null;
    }

    // The answer to a query, or the verdict on a path with `q` as the waypoint that is held; the reply is the library's, word
    // for word. A grasp that is dragged is a query.
    ask(q, cells) {
        const began = performance.now();
        const { controls } = this;
        const { points, nearest } = this.held();
        const path = points.map((point, at) => (at === nearest ? q : point.q));
        const reply = this.library.call(path.length ? { do: "path", path } : { do: "query", q, exits: this.exits, cells });
        controls.answers[controls.query] = JSON.parse(reply);
        if (path.length) controls.percent = 100 * waypointsOf(controls.shown)[nearest].at;
        controls.exit = Math.min(controls.exit, Math.max(0, controls.shown.exits.length - 1));
        controls.refresh();
        if (cells <= this.cells) {
            const better = this.cells * Math.sqrt(LIVE_CELLS.patience / Math.max(1, performance.now() - began));
            this.cells = Math.round(Math.max(LIVE_CELLS.least, Math.min(LIVE_CELLS.most, 0.5 * (this.cells + better))));
        }
        return reply;
    }

    // Moves an obstacle by a vector [m].
    push(body, by) {
        const seat = (this.moved[body.name] || body.seat).slice();
        by.forEach((x, k) => { seat[9 + k] += x; });
        this.put(body, seat);
        this.want(this.held().q);
    }

    put(body, seat) {
        this.library.call({ do: "move", obstacles: [[body.name, seat]] });
        this.moved[body.name] = seat;
        const by = [0, 1, 2].map(k => seat[9 + k] - body.seat[9 + k]);
        if (this.note) this.note.textContent = `${body.name} at ${by.map((_, k) => fixed(seat[9 + k], 3)).join(", ")} m`;
        if (stage) stage.shift(SCENE.bodies.indexOf(body), by);
    }

    // An obstacle under the pointer follows it in the plane that it was taken in: level, or upright with Shift.
    followPointer() {
        const picture = stage.renderer.domElement;
        let held = null;
        picture.addEventListener("pointerdown", event => {
            const hit = stage.bodyAt(event);
            if (!hit || !SCENE.bodies[hit.body].seat) return;
            held = { ...hit, body: SCENE.bodies[hit.body], upright: event.shiftKey };
            stage.orbit.enabled = false;
            picture.setPointerCapture(event.pointerId);
        }, { capture: true });
        picture.addEventListener("pointermove", event => {
            if (!held) return;
            const now = stage.pointInPlane(event, held.point, held.upright);
            if (!now) return;
            const by = now.map((x, k) => (held.upright === (k === 2) ? x - held.point[k] : 0));
            held.point = held.point.map((x, k) => x + by[k]);
            this.push(held.body, by);
        });
        const release = () => {
            held = null;
            stage.orbit.enabled = true;
        };
        picture.addEventListener("pointerup", release);
        picture.addEventListener("pointercancel", release);
    }
}

async function startLive() {
    try {
        window.extricate.live = new Live(await Library.open(DATA.live), controls);
    } catch (error) {
        byId("live").hidden = false;
        byId("live").append(element("p", {}, `The joints cannot be dragged here: ${error.message || error}`));
        console.error(error);
    }
    window.extricate.liveReady = performance.now();
}
