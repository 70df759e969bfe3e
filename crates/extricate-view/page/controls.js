// What is pressed and dragged: queries, exits, the slider, keys.

// Milliseconds from the query to the exit.
const PLAY_TIME = 2200;
// Milliseconds for which the query is seen before a page plays the exit.
const REST_TIME = 900;

class Controls {
    // `show` is called after every change, `showChosen` after another query or exit is chosen. `onReset` is called if the
    // picture may be turned back, and has to be turned back if it is given `true`.
    constructor(answers, { show, showChosen, onReset }) {
        Object.assign(this, { answers, show, showChosen, onReset, query: 0, exit: 0, percent: 0, playing: null, isOpening: false, keys: {} });
        this.makeQueries();
        this.makeMove();
        addEventListener("keydown", event => this.key(event));
    }

    get shown() {
        return this.answers[this.query];
    }

    makeQueries() {
        const choose = element("select", { "aria-label": "query" });
        this.answers.forEach((shown, at) => {
            choose.append(element("option", { value: String(at) }, this.nameOf(shown, at)));
        });
        choose.onchange = () => this.choose(Number(choose.value));
        this.list = choose;
        const step = (text, name, by) => {
            const button = element("button", { type: "button", title: name, "aria-label": name }, text);
            button.onclick = () => this.choose(this.query + by);
            return button;
        };
        const buttons = [step("\u2039", "previous query (P)", -1), choose, step("\u203a", "next query (N)", 1)];
        byId("queries").append(element("div", { className: "row", hidden: this.answers.length < 2 }, ...buttons));
    }

    nameOf({ answer, exits, played }, at) {
        const place = `${at + 1} of ${this.answers.length}`;
        if (played) {
            const [kind, what] = played.path ? ["path", "length"] : ["grasp", "moved"];
            return `${kind} ${place}: ${what} ${digits(exits[0].depth, 3)}${UNIT}`;
        }
        const depth = !answer ? "no answer" : exits.length ? `depth ${digits(answer.depth, 3)}${UNIT}` : "free";
        return `query ${place}: ${depth}`;
    }

    makeMove() {
        this.exits = element("div", { className: "row" });
        this.slider = element("input", { type: "range", min: "0", max: "100", step: "1", id: "slider" });
        this.slider.setAttribute("aria-label", "from the query to the exit, in percent");
        this.slider.oninput = () => this.go(Number(this.slider.value));
        this.play = element("button", { type: "button", title: "Space" }, "\u25b6 play");
        this.play.onclick = () => this.toggle();
        this.place = element("span", { id: "percent" });
        this.bar = element("div", { id: "bar" });
        this.state = element("p", { id: "state", "aria-live": "polite" });
        this.proved = element("div", { id: "proved", hidden: true, role: "img" });
        this.plot = new Plot(fraction => this.pickPlotted(fraction));
        this.playRow = element("div", { className: "row", style: "margin-top: 6px" }, this.play, this.place);
        byId("move").append(this.exits, this.slider, this.bar, this.proved, this.plot.host, this.playRow, this.state);
    }

    // A place of the plot: a frame of a motion, or a percentage of the way.
    pickPlotted(fraction) {
        if (this.player.isStream) this.player.go(Math.round(fraction * (this.answers.length - 1)));
        else this.go(Math.round(100 * fraction));
    }

    // What is known along the way or the motion.
    fillPlot() {
        const { distances = [] } = this.shown.exits[this.exit] || {};
        const isStream = this.player && this.player.isStream;
        const hasPlot = isStream ? this.answers.length > 1 : distances.some(Number.isFinite);
        this.plot.host.hidden = !hasPlot;
        if (!hasPlot) return;
        if (!isStream) {
            const across = ["0 %", `share of the ${courseOf(this.shown.exits[this.exit])}`, "100 %"];
            return this.plot.fill(distances, [], { what: "distance of the nearest pair", inWords: signedLength, across });
        }
        const of = key => this.answers.map(({ answer }) => (answer ? answer[key] : null));
        this.plot.fill(of("depth"), of("lower_bound"), {
            what: `depth (line) and lower bound (solid area)${UNIT ? "" : `, in ${UNIT_IN_WORDS}`}`,
            inWords: x => `${digits(x, 3)}${UNIT}`, across: ["1", "frame of the motion", String(this.answers.length)],
        });
    }

    pointPlot() {
        if (this.plot.host.hidden) return;
        if (this.player && this.player.isStream) {
            return this.plot.point(this.query / (this.answers.length - 1), depthInWords(this.shown));
        }
        this.plot.point(this.percent / 100, distanceInWords(this.shown.exits[this.exit].distances, this.percent));
    }

    // Segments of a path: proved free, in collision, or neither.
    fillProved() {
        const { played } = this.shown;
        const path = played && played.path;
        this.proved.hidden = !path;
        if (!path) return;
        const ends = waypointsOf(this.shown).map(({ at }) => at);
        const words = { f: "proved free", c: "in collision", u: "undecided" };
        this.proved.setAttribute("aria-label", [...path.segments].map(letter => words[letter]).join(", "));
        this.proved.replaceChildren(...[...path.segments].map((letter, at) => {
            const part = element("i", { className: letter, title: `segment ${at + 1}: ${words[letter]}` });
            part.style.flex = String(ends[at + 1] - ends[at]);
            return part;
        }));
    }

    choose(query) {
        this.isOpening = false;
        this.query = Math.max(0, Math.min(this.answers.length - 1, query));
        this.exit = 0;
        this.refresh();
        // While a motion plays, the picture stands still.
        if (!this.player || !this.player.isStream) this.onReset(false);
        if (this.player) this.player.follow();
        if (this.onChoose) this.onChoose();
    }

    pick(exit) {
        if (exit < this.shown.exits.length) this.exit = exit;
        this.refresh();
    }

    // Plays the exit that the page opens on, once, unless something else is pressed meanwhile.
    open() {
        this.isOpening = true;
        setTimeout(() => {
            if (!this.isOpening) return;
            this.toggle();
            this.isOpening = true;
        }, REST_TIME);
    }

    go(percent) {
        this.stop();
        this.isOpening = false;
        this.percent = Math.max(0, Math.min(100, percent));
        this.show();
    }

    // What depends on the query and the exit alone.
    refresh() {
        this.list.value = String(this.query);
        this.list.options[this.query].textContent = this.nameOf(this.shown, this.query);
        const { exits, played } = this.shown;
        this.exits.hidden = !!played;
        // A frame of a motion that is free has no exit, but its place in the plot.
        byId("move").hidden = !exits.length && !(this.player && this.player.isStream);
        for (const part of [this.slider, this.bar, this.playRow, this.state]) part.hidden = !exits.length;
        this.exits.replaceChildren(...exits.map(({ depth }, at) => {
            const text = `exit ${at + 1}: ${digits(depth, 3)}${UNIT}`;
            const button = element("button", { type: "button" }, text);
            button.setAttribute("aria-pressed", String(at === this.exit));
            button.onclick = () => this.pick(at);
            return button;
        }));
        if (exits.length) this.fillBar(exits[this.exit].stretches);
        this.fillPlot();
        this.fillProved();
        this.showChosen();
        this.show();
    }

    fillBar(stretches) {
        const parts = stretches.map(({ from, pairs, outside }, at) => {
            const until = at + 1 < stretches.length ? stretches[at + 1].from : 100;
            const part = element("i", { className: pairs.length || outside ? "hit" : "" });
            part.style.flex = String(Math.max(until - from, 0.5));
            return part;
        });
        this.bar.replaceChildren(...parts);
    }

    toggle() {
        this.isOpening = false;
        if (this.playing) return this.stop();
        if (this.percent >= 100) this.percent = 0;
        const [began, from] = [performance.now(), this.percent];
        this.play.textContent = "\u25a0 stop";
        const step = now => {
            this.percent = Math.min(100, from + 100 * Math.max(0, now - began) / PLAY_TIME);
            this.playing = this.percent < 100 ? requestAnimationFrame(step) : null;
            if (!this.playing) this.stop();
            this.show();
        };
        this.playing = requestAnimationFrame(step);
    }

    stop() {
        cancelAnimationFrame(this.playing);
        this.playing = null;
        this.play.textContent = "\u25b6 play";
    }

    key(event) {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const inField = ["SELECT", "INPUT"].includes(event.target.tagName) && event.target !== this.slider;
        const actions = {
            ArrowLeft: () => this.go(this.percent - (event.shiftKey ? 10 : 1)),
            ArrowRight: () => this.go(this.percent + (event.shiftKey ? 10 : 1)),
            Home: () => this.go(0), End: () => this.go(100), " ": () => this.toggle(), a: () => this.player.toggle(),
            n: () => this.choose(this.query + 1), p: () => this.choose(this.query - 1),
            r: () => this.onReset(true), ...this.keys,
        };
        const pressesButton = event.key === " " && event.target.tagName === "BUTTON";
        const action = /^[1-9]$/.test(event.key) ? () => this.pick(Number(event.key) - 1) : actions[event.key];
        if (!action || inField || pressesButton) return;
        event.preventDefault();
        action();
    }
}
