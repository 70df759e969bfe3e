// What is played back: frames of a motion one after the other, every exit of a page in turn; and what is said of paths and
// grasps, which no query answered.

// Milliseconds of a frame of a motion, and between two exits that are played in turn.
const [FRAME_TIME, PAUSE] = [60, 500];

// What the two ends of the slider are called.
function endsOf({ played }, chosen) {
    if (!played) return ["query", `exit ${chosen + 1}`];
    return played.path ? ["start", "end"] : ["query", "release"];
}

// What the slider moves along.
function courseOf(exit) {
    return exit && exit.way ? "path" : "straight segment";
}

// The waypoints of a path, each with its share of the way; none if something else is shown.
function waypointsOf({ q, exits: [exit], played }) {
    return played && played.path ? [{ at: 0, q }, ...(exit.way || []), { at: 1, q: exit.witness }] : [];
}

// Steps through all that a page shows.
class Player {
    constructor(controls, isStream) {
        Object.assign(this, { controls, isStream, timer: null });
        const count = controls.answers.length;
        this.button = element("button", { type: "button", title: "A" });
        this.button.onclick = () => this.toggle();
        this.slider = element("input", { type: "range", min: "0", max: String(count - 1), step: "1", id: "frames", hidden: !isStream });
        this.slider.setAttribute("aria-label", "frame of the motion");
        this.slider.oninput = () => this.go(Number(this.slider.value));
        this.host = element("div", { className: "row", hidden: count < 2 }, this.button, this.slider);
        byId("queries").append(this.host);
        this.said();
        controls.player = this;
        // A motion is watched where its witnesses are.
        if (isStream) controls.percent = 100;
    }

    said() {
        const what = this.isStream ? "the motion" : "all";
        this.button.textContent = this.timer === null ? `\u25b6 play ${what}` : `\u25a0 stop ${what}`;
    }

    go(at) {
        this.stop();
        this.controls.choose(at);
    }

    toggle() {
        if (this.timer !== null) return this.stop();
        if (this.host.hidden) return;
        const { controls } = this;
        const isLast = controls.query === controls.answers.length - 1;
        if (isLast && (this.isStream || controls.percent >= 100)) controls.choose(0);
        if (this.isStream) this.timer = setInterval(() => this.frame(), FRAME_TIME);
        else this.one();
        this.said();
    }

    // The next frame of a motion.
    frame() {
        const { controls } = this;
        if (controls.query + 1 >= controls.answers.length) return this.stop();
        controls.choose(controls.query + 1);
    }

    // The exit that is shown, from its beginning, then the next.
    one() {
        const { controls } = this;
        controls.stop();
        controls.percent = 0;
        controls.toggle();
        const next = () => {
            if (controls.playing) {
                this.timer = setTimeout(next, PAUSE);
            } else if (controls.query + 1 >= controls.answers.length) {
                this.stop();
            } else {
                controls.choose(controls.query + 1);
                this.one();
            }
        };
        this.timer = setTimeout(next, PLAY_TIME + PAUSE);
    }

    stop() {
        clearInterval(this.timer);
        clearTimeout(this.timer);
        this.timer = null;
        this.said();
    }

    // After another query was chosen.
    follow() {
        this.slider.value = String(this.controls.query);
    }
}

function rowsOfPath(path, exit) {
    const segments = path.waypoints - 1;
    const unknown = segments - path.free_segments - path.colliding_segments;
    const rows = [
        ["waypoints", number("waypoints", path.waypoints, String(path.waypoints))],
        ["length", number("length", path.length, `${digits(path.length)}${UNIT}`)],
        ["largest displacement", number("max_displacement", exit.max_displacement, lengthInWords(exit.max_displacement))],
        ["proved free", number("free_segments", path.free_segments, `${path.free_segments} of ${segments} segments`)],
        ["in collision", number("colliding_segments", path.colliding_segments, `${path.colliding_segments} of ${segments} segments`)],
    ];
    if (unknown) rows.push(["undecided", number("undecided_segments", unknown, `${unknown} of ${segments} segments`)]);
    if (path.first_collision !== null) {
        rows.push(["first collision", number("first_collision", path.first_collision, `at ${digits(100 * path.first_collision)} %`)]);
    }
    return rows;
}

function rowsOfGrasp(grasp, exit) {
    const names = links => (links.length ? links.join(", ") : "none");
    const list = (key, links) => element("span", { "data-key": key, "data-value": JSON.stringify(links) }, names(links));
    const yes = is => (is ? "yes" : "no");
    const rows = [
        ["moved", number("moved", grasp.moved, `${digits(grasp.moved)}${UNIT}`)],
        ["largest displacement", number("max_displacement", exit.max_displacement, lengthInWords(exit.max_displacement))],
        ["depth before", number("depth_before", grasp.depth_before, lengthInWords(grasp.depth_before))],
        ["verified", number("verified", grasp.verified, yes(grasp.verified))],
        ["touched", list("touched", grasp.touched)],
        ["kept", list("kept", grasp.kept)],
        ["kept sides", number("kept_sides", grasp.kept_sides, yes(grasp.kept_sides))],
    ];
    if (grasp.quality) {
        rows.push(["epsilon", number("epsilon", grasp.quality.epsilon, digits(grasp.quality.epsilon))],
            ["force closure", number("force_closure", grasp.quality.force_closure, yes(grasp.quality.force_closure))]);
    }
    return rows;
}

// Heading and rows of what is played back.
function playedInWords({ played, exits }) {
    return played.path ? ["The path", rowsOfPath(played.path, exits[0])] : ["The grasp, released", rowsOfGrasp(played.grasp, exits[0])];
}
