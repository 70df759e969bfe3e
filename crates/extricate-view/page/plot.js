// What happens along a way or a motion, as a plot with a cursor: distances of the nearest pair, or depths of frames.

// The name space of SVG, from the browser: a page holds no address of the network.
const SVG = element("div", { innerHTML: "<svg></svg>" }).firstChild.namespaceURI;

function drawn(tag, attributes) {
    const made = document.createElementNS(SVG, tag);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
}

// A plot of values, of which `null` leaves a gap; `onPick` is called with a fraction of the width.
// The label of the vertical axis is above the plot, that of the horizontal axis below it.
class Plot {
    constructor(onPick) {
        this.svg = drawn("svg", { id: "plot", viewBox: "0 0 1 1", preserveAspectRatio: "none", role: "img" });
        this.upright = element("p", { className: "axis" });
        this.level = element("p", { className: "axis" });
        this.caption = element("small");
        this.host = element("div", { id: "plotted" }, this.upright, this.svg, this.level, this.caption);
        const pick = event => {
            const box = this.svg.getBoundingClientRect();
            onPick(Math.max(0, Math.min(1, (event.clientX - box.left) / box.width)));
        };
        this.svg.addEventListener("pointerdown", event => {
            this.svg.setPointerCapture(event.pointerId);
            pick(event);
        });
        this.svg.addEventListener("pointermove", event => { if (event.buttons) pick(event); });
        this.cursor = drawn("line", { class: "cursor", y1: 0, y2: 1 });
    }

    // `values` as a line over zero; `proved` lies below them. `what` names the values, and `inWords`
    // writes one with its unit. `across` has both ends of the horizontal axis, and its name between.
    fill(values, proved, { what, inWords, across }) {
        const all = [0, ...values, ...proved].filter(Number.isFinite);
        const [low, high] = [Math.min(...all), Math.max(...all)];
        const height = y => (high > low ? 0.04 + 0.92 * (high - y) / (high - low) : 0.5);
        const wide = at => (values.length > 1 ? at / (values.length - 1) : 0);
        const points = line => line.map((y, at) => `${wide(at)},${height(Number.isFinite(y) ? y : high)}`).join(" ");
        const area = (line, name) => drawn("polygon", { class: name, points: `0,${height(0)} ${points(line)} 1,${height(0)}` });
        const parts = proved.length ? [area(values, "above"), area(proved, "proof")]
            : [area(values.map(y => Math.max(y, 0)), "above"), area(values.map(y => Math.min(y, 0)), "below")];
        const label = `${what}, from ${inWords(low)} to ${inWords(high)}${low < 0 && high > 0 ? " (dashed: 0)" : ""}`;
        this.upright.textContent = `\u2191 ${label}`;
        this.level.replaceChildren(...across.map(text => element("span", {}, text)));
        this.svg.setAttribute("aria-label", `${label}, by ${across[1]}`);
        this.svg.replaceChildren(...parts, drawn("line", { class: "zero", x1: 0, x2: 1, y1: height(0), y2: height(0) }),
            drawn("polyline", { class: "line", points: points(values) }), this.cursor);
    }

    point(fraction, text) {
        this.cursor.setAttribute("x1", fraction);
        this.cursor.setAttribute("x2", fraction);
        this.caption.textContent = text;
    }
}

function signedLength(metres) {
    return (metres < 0 ? "\u2212" : "") + lengthInWords(Math.abs(metres));
}

// How near the nearest pair is at a percentage of the straight segment or path.
function distanceInWords(distances, percent) {
    const at = Math.floor(percent);
    const [low, high] = [distances[at], distances[Math.min(at + 1, 100)]];
    const now = low + (percent - at) * (high - low);
    if (!Number.isFinite(now)) return "";
    return `Here: ${signedLength(now)}${now < 0 ? ", the pair overlaps" : ""}.`;
}

// The depth and the lower bound of a frame of a motion.
function depthInWords({ answer }) {
    if (!answer) return "No exit was found for this frame.";
    return `Here: depth ${digits(answer.depth, 3)}${UNIT}, lower bound ${digits(answer.lower_bound, 3)}${UNIT}.`;
}
