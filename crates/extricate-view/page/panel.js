// The panel: numbers of the answer and of its proof, and the joints. Every number has its full value in `data-value`.

// Pairs of a list that are shown at first.
const MOST_PAIRS = 3;
// The unit after a distance of the metric. Radians and metres in one sum have none.
const UNIT = SCENE.unit === "rad, m" ? "" : ` ${SCENE.unit}`;
const UNIT_IN_WORDS = SCENE.unit !== "rad, m" ? SCENE.unit
    : SCENE.factors.every(({ weight }) => weight === 1) ? "rad and m in one sum: 1 rad counts as 1 m" : "rad and m in one sum, weighted";

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

// Pairs of bodies; a press lights one up in the picture.
function pairList(key, shown, pairs) {
    const names = pairNames(shown, pairs);
    const list = element("div", { "data-key": key, "data-value": JSON.stringify(names) });
    if (!names.length) list.append("nothing");
    const buttons = names.map((pair, at) => {
        const button = element("button", { type: "button", className: "pair", title: "show this pair alone" }, pair.join(" \u2013 "));
        button.setAttribute("aria-pressed", "false");
        button.onclick = () => {
            const isLit = button.getAttribute("aria-pressed") !== "true";
            document.querySelectorAll(".pair").forEach(other => other.setAttribute("aria-pressed", String(isLit && other === button)));
            light(isLit ? shown.pairs[pairs[at]] : null);
        };
        return button;
    });
    list.append(...buttons.slice(0, MOST_PAIRS));
    if (buttons.length > MOST_PAIRS) {
        const more = element("button", { type: "button", className: "pair" }, `and ${buttons.length - MOST_PAIRS} more`);
        more.onclick = () => more.replaceWith(...buttons.slice(MOST_PAIRS));
        list.append(more);
    }
    return list;
}

function namesOfCoordinates(coordinates) {
    const joints = SCENE.joints.filter(({ first, count }) => coordinates.some(at => at >= first && at < first + count));
    return joints.map(joint => joint.name);
}

// What is asked first: what collides, where the nearest exit is, and how sure that is.
function verdictOf(shown, chosen) {
    const { answer, exits } = shown;
    const exit = exits[chosen];
    const depth = number(chosen ? "exit_depth" : "depth", exit.depth, `${digits(exit.depth)}${UNIT}`);
    const moved = number(chosen ? "exit_max_displacement" : "max_displacement", exit.max_displacement, lengthInWords(exit.max_displacement));
    return [
        ["in collision", pairList("colliding", shown, answer.colliding)],
        [chosen ? "exit" : "depth", [element("b", { className: "free" }, depth), ` to ${chosen ? "this" : "the nearest"} exit; no point moves more than `, moved,
            ...(UNIT ? [] : [element("br"), element("small", {}, UNIT_IN_WORDS)])]],
        ["lower bound", proofOf(answer)],
    ];
}

// How much of the depth is proved, as a bar with its figure below.
function proofOf(answer) {
    const share = answer.depth > 0 ? Math.min(1, answer.lower_bound / answer.depth) : 0;
    const bound = number("lower_bound", answer.lower_bound, `${digits(answer.lower_bound)}${UNIT}`);
    if (answer.unproved) {
        const why = {
            surfaces: "what collides are surfaces, which enclose nothing", shallow: "the overlap is too shallow",
            off: "nothing collides, and a kept link is off",
        };
        return [element("b", {}, bound), ` Nothing is proved: ${why[answer.unproved]}.`];
    }
    const [proved, open] = ["proved", "open"].map(name => element("i", { className: name }));
    proved.style.width = `${100 * share}%`;
    return ["Proved: no free configuration is nearer than ", element("b", {}, bound), ".", element("div", { id: "proof" }, proved, open),
        element("small", {}, `${digits(100 * share, 3)} % of the depth is proved`)];
}

// What else is known of the answer.
function moreRowsOf(shown, chosen) {
    const { answer, exits, seconds } = shown;
    const rows = [["touching", pairList(chosen ? "exit_touching" : "touching", shown, exits[chosen].touching)]];
    if (answer.outside.length) rows.push(["outside", namesOfCoordinates(answer.outside).join(", ")]);
    rows.push(
        ["gap", number("gap", answer.gap, `${digits(100 * answer.gap, 3)} %`)],
        ["verified", number("verified", answer.verified, answer.verified ? "yes" : "when the model was learned")],
        ["clearance", number("clearance", answer.clearance, lengthInWords(answer.clearance))],
        ["unique", number("unique", answer.unique, answer.unique ? "yes" : "no: another exit is about as near")]);
    if (answer.cut_short && answer.gap > 0.5) {
        rows.push(["cut short", number("cut_short", answer.cut_short, "a limit ended the search, and a nearer exit is not ruled out")]);
    }
    if (answer.free_radius !== null) {
        rows.push(["free radius", number("free_radius", answer.free_radius, `${digits(answer.free_radius)}${UNIT}`)]);
    }
    if (answer.unseen !== null) rows.push(["unseen", number("unseen", answer.unseen, digits(answer.unseen, 3))]);
    rows.push(["checks", number("checks", answer.checks, String(answer.checks))]);
    if (seconds !== null) rows.push(["time", number("seconds", seconds, timeInWords(seconds))]);
    rows.push(["effort", number("effort", answer.effort, answer.effort)], ["metric", `${SCENE.metric}, in ${UNIT_IN_WORDS}`]);
    return rows;
}

function tableOf(rows, id) {
    const row = ([name, value]) => element("tr", {}, element("td", {}, word(name, 2)), element("td", {}, ...[value].flat()));
    return element("table", id ? { id } : {}, element("tbody", {}, ...rows.map(row)));
}

function showNumbers(shown, chosen) {
    const [host, more] = [byId("numbers"), byId("more")];
    const { answer, exits } = shown;
    more.hidden = !answer || !exits.length;
    if (shown.played) {
        const [heading, rows] = playedInWords(shown);
        return host.replaceChildren(element("h2", {}, heading), tableOf(rows));
    }
    if (!answer) return host.replaceChildren(element("p", {}, "No free configuration was found."));
    if (!exits.length) {
        return host.replaceChildren(element("p", {}, element("b", {}, "This configuration is free"), ": nothing collides, and the depth is ",
            number("depth", answer.depth, "0"), "."));
    }
    host.replaceChildren(tableOf(verdictOf(shown, chosen), "verdict"));
    const wasOpen = !!more.querySelector("details[open]");
    more.replaceChildren(element("details", { open: wasOpen },
        element("summary", {}, "More numbers"), tableOf(moreRowsOf(shown, chosen))));
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

// With a sign only if a digit other than 0 follows.
function fixed(x, count) {
    const text = Math.abs(x).toFixed(count);
    return (x < 0 && Number(text) ? "\u2212" : "") + text;
}

// Angles in degrees, lengths in metres.
function inUnit(at, x) {
    return isAngle(at) ? `${fixed(x * 180 / Math.PI, 1)}\u00b0` : fixed(x, 3);
}

// A name that may go on in another line after its parts.
function breakable(name) {
    return name.split(/(?<=[_/])/).flatMap(part => [part, element("wbr")]);
}

function cell(key) {
    return element("td", { className: "n", "data-joint": key });
}

function fillCell(made, text, value) {
    made.textContent = text;
    made.title = made.dataset.value = String(value);
}

// The joints of a query and an exit; `showNow` fills in where the robot is.
function showJoints(shown, chosen) {
    const exit = shown.exits[chosen];
    const ends = endsOf(shown, chosen);
    const head = ["joint", "now", "", ...ends, "change"].map((name, at) => element("th", { className: at ? "n" : "" }, name));
    const rows = shown.q.map((x, at) => {
        const [now, degrees, query, end, change] = ["now", "degrees", "query", "exit", "change"].map(cell);
        fillCell(query, fixed(x, 3), x);
        if (exit) {
            fillCell(end, fixed(exit.witness[at], 3), exit.witness[at]);
            fillCell(change, inUnit(at, exit.witness[at] - x), exit.witness[at] - x);
        }
        return element("tr", {}, element("td", {}, ...breakable(nameOfCoordinate(at))), now, degrees, query, end, change);
    });
    byId("joints").replaceChildren(element("h2", {}, "Joints, in rad and degrees, or m"),
        element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)),
        ...(exit ? [copyButtons(ends[1], exit.witness)] : []));
}

function showNow(now) {
    const [radians, degrees] = ["now", "degrees"].map(key => document.querySelectorAll(`#joints [data-joint=${key}]`));
    now.forEach((x, at) => {
        fillCell(radians[at], fixed(x, 4), x);
        fillCell(degrees[at], isAngle(at) ? inUnit(at, x) : "", x * 180 / Math.PI);
    });
}
