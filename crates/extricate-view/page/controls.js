// What is pressed and dragged: queries, exits, the slider, keys.

// Milliseconds from the query to the exit.
const PLAY_TIME = 2200;

class Controls {
    // `show` is called after every change, `onReset` where the picture may be turned back, and has to be where it is given
    // `true`.
    constructor(answers, show, onReset) {
        Object.assign(this, { answers, show, onReset, query: 0, exit: 0, percent: 0, playing: null });
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
            return `${kind} ${place}: ${what} ${digits(exits[0].depth, 3)} ${SCENE.unit}`;
        }
        const depth = !answer ? "no answer" : exits.length ? `depth ${digits(answer.depth, 3)} ${SCENE.unit}` : "free";
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
        byId("move").append(this.exits, this.slider, this.bar,
            element("div", { className: "row", style: "margin-top: 6px" }, this.play, this.place), this.state);
    }

    choose(query) {
        this.query = Math.max(0, Math.min(this.answers.length - 1, query));
        this.exit = 0;
        // While a motion plays, the picture stands still.
        if (!this.player || !this.player.isStream) this.onReset(false);
        this.refresh();
        if (this.player) this.player.follow();
        if (this.onChoose) this.onChoose();
    }

    pick(exit) {
        if (exit < this.shown.exits.length) this.exit = exit;
        this.refresh();
    }

    go(percent) {
        this.stop();
        this.percent = Math.max(0, Math.min(100, percent));
        this.show();
    }

    // What depends on the query and the exit alone.
    refresh() {
        this.list.value = String(this.query);
        const { exits, played } = this.shown;
        this.exits.hidden = !!played;
        byId("move").hidden = !exits.length;
        this.exits.replaceChildren(...exits.map(({ depth }, at) => {
            const text = `exit ${at + 1}: ${digits(depth, 3)} ${SCENE.unit}`;
            const button = element("button", { type: "button" }, text);
            button.setAttribute("aria-pressed", String(at === this.exit));
            button.onclick = () => this.pick(at);
            return button;
        }));
        if (exits.length) this.fillBar(exits[this.exit].stretches);
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
            r: () => this.onReset(true),
        };
        const pressesButton = event.key === " " && event.target.tagName === "BUTTON";
        const action = /^[1-9]$/.test(event.key) ? () => this.pick(Number(event.key) - 1) : actions[event.key];
        if (!action || inField || pressesButton) return;
        event.preventDefault();
        action();
    }
}
