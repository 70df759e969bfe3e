// What leaves the page: a witness as text, a link to what is shown, a picture.

// Puts text on the clipboard, and says so on the button for a moment.
async function copy(button, text) {
    const name = button.textContent;
    try {
        await navigator.clipboard.writeText(text);
    } catch {
        // A page in a frame may not write to the clipboard otherwise.
        const field = element("textarea", { value: text });
        document.body.append(field);
        field.select();
        document.execCommand("copy");
        field.remove();
    }
    button.textContent = "copied";
    setTimeout(() => { button.textContent = name; }, 900);
}

// The spellings of a configuration: numbers keep all of their digits.
const SPELLINGS = {
    JSON: q => JSON.stringify(q),
    NumPy: q => `np.array([${q.join(", ")}])`,
    // sensor_msgs/JointState as YAML. A joint of several coordinates has no place in it.
    JointState: q => (SCENE.joints.every(({ count }) => count === 1)
        ? `name: ${JSON.stringify(SCENE.joints.map(joint => joint.name))}\nposition: ${JSON.stringify(q)}\n` : null),
};

// Buttons that copy a configuration.
function copyButtons(name, q) {
    const buttons = Object.entries(SPELLINGS).filter(([, spell]) => spell(q)).map(([spelling, spell]) => {
        const button = element("button", { type: "button" }, spelling);
        button.setAttribute("aria-label", `copy ${name} as ${spelling}`);
        button.onclick = () => copy(button, spell(q));
        return button;
    });
    return element("div", { className: "row" }, element("span", {}, `Copy ${name}:`), ...buttons);
}

// What a link holds: the query, the exit, the percentage of the way and the view, as in `#q=3&e=1&t=40&c=...`.
function hashOf(controls, stage) {
    const view = stage ? `&c=${viewAsText(stage)}` : "";
    return `#q=${controls.query + 1}&e=${controls.exit + 1}&t=${Number(controls.percent.toFixed(1))}${view}`;
}

// Shows what a link holds; returns whether it holds anything.
function takeHash(controls, stage) {
    const held = new URLSearchParams(location.hash.slice(1));
    const number = name => (held.has(name) && Number.isFinite(Number(held.get(name))) ? Number(held.get(name)) : null);
    const [query, exit, percent] = ["q", "e", "t"].map(number);
    if (query !== null) controls.choose(Math.round(query) - 1);
    if (exit !== null) controls.pick(Math.max(0, Math.round(exit) - 1));
    if (percent !== null) controls.go(percent);
    if (stage && held.has("c")) takeView(stage, held.get("c"));
    return query !== null || percent !== null;
}

function makeTools(controls, stage, turnBack) {
    const tool = (text, title, action) => {
        const button = element("button", { type: "button", title }, text);
        button.onclick = () => action(button);
        byId("tools").append(button);
    };
    tool("turn back", "R", () => turnBack(true));
    tool("copy link", "to this query, exit and view", button => {
        try {
            history.replaceState(null, "", hashOf(controls, stage));
        } catch {
            // A page in a frame of a notebook has no address.
        }
        copy(button, location.href);
    });
    tool("save picture", "as PNG", () => {
        stage.drawAt(true);
        element("a", { href: stage.renderer.domElement.toDataURL(), download: `${DATA.title}.png` }).click();
    });
    addEventListener("hashchange", () => takeHash(controls, stage));
}
