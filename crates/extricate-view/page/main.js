// Puts the page together, and shows what the controls say.

const DATA = JSON.parse(byId("data").textContent);
const SCENE = DATA.scene;

// The picture, or none where the browser has no WebGL; the numbers are shown all the same.
function makeStage() {
    try {
        return new Stage(byId("stage"), SCENE);
    } catch (error) {
        const text = "This browser shows no 3D picture (WebGL is off). The numbers are those of the answer.";
        byId("stage").append(element("p", { className: "failed" }, text));
        return null;
    }
}

const stage = makeStage();
const canvas = element("canvas", { width: 760, height: 760 });
const caption = element("small");
byId("plane").append(element("h2", {}, "Slice of the configuration space"), canvas, caption);

// Bodies of some pairs.
function bodiesOf(shown, pairs) {
    return new Set(pairs.flatMap(pair => shown.pairs[pair]));
}

// Pairs that collide at the query.
function collidingAt({ answer, exits, played }) {
    return answer ? answer.colliding : played ? exits[0].stretches[0].pairs : [];
}

// What collides at a percent of the segment: that of the last percent that was checked.
function stretchAt(exit, percent) {
    const at = Math.floor(percent + 1e-9);
    return exit.stretches.filter(stretch => stretch.from <= at).pop();
}

function stateInWords(shown, stretch) {
    if (!stretch.pairs.length && !stretch.outside) return [element("b", { className: "free" }, "Free.")];
    const pairs = pairNames(shown, stretch.pairs).map(pair => pair.join(" \u2013 "));
    const beyond = stretch.outside ? ["a joint is beyond its limits"] : [];
    const text = [...pairs, ...beyond];
    const more = text.length > 4 ? ` and ${text.length - 4} more` : "";
    const title = stretch.pairs.length ? "In collision: " : "Not free: ";
    return [element("b", { className: "hit" }, title), text.slice(0, 4).join(", ") + more];
}

function show() {
    const { shown, exit: chosen, percent } = controls;
    const exit = shown.exits[chosen];
    const now = exit ? along(SCENE, shown.q, exit, percent / 100) : shown.q;
    const [begins, ends] = endsOf(shown, chosen);
    const colliding = bodiesOf(shown, collidingAt(shown));
    const stretch = exit ? stretchAt(exit, percent) : { pairs: [], outside: false };
    controls.slider.value = String(Math.round(percent));
    const course = exit && exit.way ? "path" : "straight segment";
    controls.place.textContent = percent <= 0 ? `at the ${begins}` : percent >= 100 ? `at ${shown.played ? "the " : ""}${ends}`
        : `${Math.round(percent)} % of the ${course}`;
    controls.state.replaceChildren(...stateInWords(shown, stretch));
    if (stage) {
        stage.place("solid", placed(SCENE, now));
        stage.colour(bodiesOf(shown, stretch.pairs), !stretch.pairs.length && !stretch.outside && !!(shown.answer || shown.played));
        stage.place("ghost", placed(SCENE, shown.q));
        stage.colourGhost(colliding);
        stage.place("target", placed(SCENE, exit ? exit.witness : shown.q));
        // A ghost in the very place of the robot only flickers.
        stage.layers.ghost.visible = layers.ghost.checked && percent > 0;
        stage.layers.target.visible = layers.target.checked && percent < 100;
        stage.showContacts(exit ? exit.contacts : []);
    }
    showNumbers(shown, chosen);
    showJoints(shown, chosen, now);
    byId("plane").hidden = !shown.slice;
    if (shown.slice) {
        drawSlice(canvas, shown.slice, chosen, percent / 100, SCENE.unit);
        caption.textContent = captionOf(shown.slice, chosen, shown.slice.rings[0].length > 0);
    }
}

// Where what collides at the query is: the mean of its obstacles' or links' middles.
function hitAt(shown) {
    if (!stage) return null;
    const poses = placed(SCENE, shown.q);
    const middles = [...bodiesOf(shown, collidingAt(shown))].filter(body => stage.bodies[body]).map(body => {
        const { geometry } = stage.bodies[body];
        geometry.computeBoundingBox();
        const middle = geometry.boundingBox.getCenter(new THREE.Vector3());
        const pose = composed(poses[SCENE.bodies[body].frame], Float64Array.of(...IDENTITY.slice(0, 9), middle.x, middle.y, middle.z));
        return [...pose.slice(9)];
    });
    return middles.length ? [0, 1, 2].map(k => middles.reduce((sum, m) => sum + m[k], 0) / middles.length) : null;
}

// Turns the picture to the query that is shown, unless someone has turned it and it need not be.
function frameAll(always) {
    if (!stage || (stage.isTurned && !always)) return;
    stage.isTurned = false;
    const { shown } = controls;
    // Of a motion, some twenty of its frames.
    const step = Math.ceil(DATA.answers.length / 20);
    const all = DATA.stream ? DATA.answers.filter((_, at) => at % step === 0) : [shown];
    const ends = all.flatMap(({ q, exits }) => [q, ...exits.flatMap(({ way = [], witness }) => [...way.map(point => point.q), witness])]);
    stage.frameAll(ends.map(q => placed(SCENE, q)), hitAt(shown));
}

function makeLegend() {
    const entries = [["#d55e00", "collides"], ["#2f86c1", "free"], ["#93a1b3", "other links"], ["#c8bfa6", "obstacles"]];
    const swatch = ([colour, text]) => {
        const box = element("i");
        box.style.background = colour;
        return element("span", {}, box, text);
    };
    byId("legend").append(...entries.map(swatch));
}

// Which parts of the picture are shown.
function makeLayers() {
    const entries = { ghost: "query as a ghost", target: "exit as a ghost", obstacles: "obstacles", contacts: "contacts", grid: "grid" };
    const boxes = {};
    for (const [name, text] of Object.entries(entries)) {
        const box = element("input", { type: "checkbox", checked: name !== "target" });
        box.onchange = () => {
            if (stage) stage.layers[name].visible = box.checked;
            show();
        };
        boxes[name] = box;
        byId("layers").append(element("label", {}, box, " " + text));
    }
    return boxes;
}

const layers = makeLayers();
const controls = new Controls(DATA.answers, show, frameAll);
const player = new Player(controls, DATA.stream);
document.title = `${DATA.title} \u2013 extricate`;
byId("title").textContent = DATA.title;
byId("made").textContent = DATA.made;
makeLegend();
listOfWords();
if (kinematicError(SCENE) > 1e-6) console.error("the page places links elsewhere than the library");
if (stage) stage.resize();
if (DATA.answers.length) {
    frameAll(true);
    controls.refresh();
}
// For scripts that drive the page.
window.extricate = { controls, player, stage, data: DATA, ready: performance.now() };
if (DATA.live && DATA.answers.length) startLive();
