// The panel: numbers of the answer and of its proof, and the joints. Every number has its full value in `data-value`.

function digits(x, count) {
    return Number.isFinite(x) ? String(Number(x.toPrecision(count || 4))) : "\u2013";
}

// A number with its unit; `key` names it as `query --json` does.
function number(key, value, text) {
    return element("span", { title: String(value), "data-key": key, "data-value": String(value) }, text);
}

function lengthInWords(metres) {
    if (Math.abs(metres) < 1e-3) return `${digits(1e3 * metres, 3)} mm`;
    return Math.abs(metres) < 1 ? `${digits(100 * metres, 3)} cm` : `${digits(metres, 4)} m`;
}

function timeInWords(seconds) {
    if (seconds < 1e-3) return `${digits(1e6 * seconds, 3)} \u00b5s`;
    return seconds < 1 ? `${digits(1e3 * seconds, 3)} ms` : `${digits(seconds, 3)} s`;
}

function pairNames(shown, pairs) {
    return pairs.map(pair => shown.pairs[pair].map(body => SCENE.bodies[body].name));
}

function pairList(key, shown, pairs) {
    const names = pairNames(shown, pairs);
    const list = element("span", { "data-key": key, "data-value": JSON.stringify(names) });
    if (!names.length) list.append("nothing");
    names.forEach((pair, at) => list.append(...(at ? [element("br")] : []), pair.join(" \u2013 ")));
    return list;
}

function namesOfCoordinates(coordinates) {
    const joints = SCENE.joints.filter(({ first, count }) => coordinates.some(at => at >= first && at < first + count));
    return joints.map(joint => joint.name);
}

// What is asked first, for the exit that is chosen.
function rowsOf(shown, chosen) {
    const { answer, exits } = shown;
    const [exit, unit] = [exits[chosen], SCENE.unit];
    const rows = [
        ["depth", chosen ? number("exit_depth", exit.depth, `${digits(exit.depth)} ${unit}`)
            : number("depth", answer.depth, `${digits(answer.depth)} ${unit}`)],
        ["lower bound", number("lower_bound", answer.lower_bound, lowerBoundInWords(answer, unit))],
    ];
    if (!chosen) rows.push(["gap", number("gap", answer.gap, `${digits(100 * answer.gap, 3)} %`)]);
    rows.push(
        ["largest displacement",
            number(chosen ? "exit_max_displacement" : "max_displacement", exit.max_displacement, lengthInWords(exit.max_displacement))],
        ["in collision", pairList("colliding", shown, answer.colliding)],
        ["touching", pairList(chosen ? "exit_touching" : "touching", shown, exit.touching)]);
    if (answer.outside.length) rows.push(["outside", namesOfCoordinates(answer.outside).join(", ")]);
    return rows;
}

// What else is known of the answer.
function moreRowsOf({ answer, seconds }) {
    const unit = SCENE.unit;
    const rows = [
        ["verified", number("verified", answer.verified, answer.verified ? "yes" : "when the model was learned")],
        ["clearance", number("clearance", answer.clearance, lengthInWords(answer.clearance))],
        ["unique", number("unique", answer.unique, answer.unique ? "yes" : "no: another exit is about as near")],
    ];
    if (answer.cut_short && answer.gap > 0.5) {
        rows.push(["cut short", number("cut_short", answer.cut_short, "a limit ended the search, and a nearer exit is not ruled out")]);
    }
    if (answer.free_radius !== null) {
        rows.push(["free radius", number("free_radius", answer.free_radius, `${digits(answer.free_radius)} ${unit}`)]);
    }
    if (answer.unseen !== null) rows.push(["unseen", number("unseen", answer.unseen, digits(answer.unseen, 3))]);
    rows.push(["checks", number("checks", answer.checks, String(answer.checks))]);
    if (seconds !== null) rows.push(["time", number("seconds", seconds, timeInWords(seconds))]);
    rows.push(["effort", number("effort", answer.effort, answer.effort)], ["metric", `${SCENE.metric} [${unit}]`]);
    return rows;
}

function lowerBoundInWords(answer, unit) {
    if (answer.unproved === "surfaces") return "0: what collides are surfaces, which enclose nothing";
    if (answer.unproved === "shallow") return "0: the overlap is too shallow to prove anything";
    return `${digits(answer.lower_bound)} ${unit}`;
}

function proofBar(answer) {
    const share = answer.depth > 0 ? Math.min(1, answer.lower_bound / answer.depth) : 0;
    const part = (name, width, text) => {
        const made = element("i", { className: name, title: text }, text);
        made.style.width = `${100 * width}%`;
        return made;
    };
    return element("div", { id: "proof" },
        part("proved", share, `nothing free: proved for ${digits(100 * share, 3)} %`),
        part("open", 1 - share, share < 0.75 ? "not proved" : ""));
}

function showNumbers(shown, chosen) {
    const host = byId("numbers");
    const { answer, exits } = shown;
    const row = ([name, value]) => element("tr", {}, element("td", {}, word(name, 2)), element("td", {}, value));
    const table = rows => element("table", {}, element("tbody", {}, ...rows.map(row)));
    if (shown.played) {
        const [heading, rows] = playedInWords(shown);
        return host.replaceChildren(element("h2", {}, heading), table(rows), element("small", {}, "Press a word to read what it means."));
    }
    if (!answer) return host.replaceChildren(element("p", {}, "No free configuration was found."));
    if (!exits.length) {
        return host.replaceChildren(element("p", {}, "This configuration is free: nothing collides, and the depth is ",
            number("depth", answer.depth, "0"), "."));
    }
    const bar = chosen ? [] : [element("small", {}, "From the query (left) to the nearest exit (right):"), proofBar(answer)];
    const wasOpen = !!host.querySelector("details[open]");
    host.replaceChildren(element("h2", {}, chosen ? `Exit ${chosen + 1}` : "The answer, and its proof"), ...bar,
        table(rowsOf(shown, chosen)), element("small", {}, "Press a word to read what it means."),
        element("details", { open: wasOpen }, element("summary", {}, "More numbers"), table(moreRowsOf(shown))));
}

// Angles of a joint in degrees as well; lengths in metres alone.
function isAngle(coordinate) {
    const joint = SCENE.joints.find(({ first, count }) => coordinate >= first && coordinate < first + count);
    return !!joint && joint.count === 1 && joint.kind !== "prismatic";
}

function nameOfCoordinate(at) {
    const joint = SCENE.joints.find(({ first, count }) => at >= first && at < first + count);
    const part = joint.count === 1 ? "" : `.${joint.count === 4 ? "xyzw"[at - joint.first] : at - joint.first}`;
    return joint.name + part;
}

function fixed(x, count) {
    return (x < 0 ? "\u2212" : "") + Math.abs(x).toFixed(count);
}

function jointRow(at, now, shown, chosen) {
    const exit = shown.exits[chosen];
    const inUnit = x => (isAngle(at) ? `${fixed(x * 180 / Math.PI, 1)}\u00b0` : "");
    const change = exit ? exit.witness[at] - shown.q[at] : 0;
    const cell = (key, text, value) =>
        element("td", { className: "n", title: String(value), "data-joint": key, "data-value": String(value) }, text);
    return element("tr", {}, element("td", {}, nameOfCoordinate(at)),
        cell("now", fixed(now[at], 4), now[at]), cell("degrees", inUnit(now[at]), now[at] * 180 / Math.PI),
        cell("query", fixed(shown.q[at], 3), shown.q[at]),
        cell("exit", exit ? fixed(exit.witness[at], 3) : "", exit ? exit.witness[at] : ""),
        cell("change", exit ? inUnit(change) || fixed(change, 3) : "", change));
}

function showJoints(shown, chosen, now) {
    const ends = shown.played ? endsOf(shown, chosen) : ["query", "exit"];
    const heads = ["joint", "now", "", ...ends, "change"];
    const head = element("tr", {}, ...heads.map((name, at) => element("th", { className: at ? "n" : "" }, name)));
    const rows = now.map((_, at) => jointRow(at, now, shown, chosen));
    byId("joints").replaceChildren(element("h2", {}, "Joints, in rad and degrees, or m"),
        element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows)));
}
