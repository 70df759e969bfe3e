// Puts the page together, and shows what the controls say.

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
const canvas = element("canvas", { width: 760, height: 760, role: "img" });
// Drawn by the processor: where that draws everything, this spares it a detour.
canvas.getContext("2d", { willReadFrequently: true });
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

// What colours, ghosts and arrows of the picture mean: those that are drawn now.
function drawnInWords(shown, chosen, hit, isFree) {
    const [begins, ends] = endsOf(shown, chosen);
    const isHitShown = stage.bodies.some(made => made && hit.has(made.at) && made.solid.visible && made.solid.parent.visible);
    const balls = SCENE.stand_ins.reduce((sum, one) => sum + one.balls.length, 0);
    const inWords = count => count.toLocaleString("en");
    return [
        [isHitShown, "Orange bodies collide."],
        [isFree && stage.draws("solid"), "The blue robot is free."],
        [stage.draws("target"), `The blue ghost is ${shown.played ? "the " : ""}${ends}.`],
        [stage.draws("ghost"), `The grey ghost is the ${begins}${collidingAt(shown).length ? "; its links that collide are orange" : ""}.`],
        [stage.draws("contacts"), "Arrows show contacts, and the direction in which the bodies part."],
        [stage.draws("stand_ins") && balls < SCENE.balls, `${inWords(balls)} of ${inWords(SCENE.balls)} balls are drawn.`],
    ].filter(([isDrawn]) => isDrawn).map(([, text]) => text).join(" ");
}

// Where the robot is: at the query, at the exit, or between.
function show() {
    const { shown, exit: chosen, percent } = controls;
    const exit = shown.exits[chosen];
    const now = exit ? along(SCENE, shown.q, exit, percent / 100) : shown.q;
    const [begins, ends] = endsOf(shown, chosen);
    const stretch = exit ? stretchAt(exit, percent) : { pairs: [], outside: false };
    controls.slider.value = String(Math.round(percent));
    controls.place.textContent = percent <= 0 ? `at the ${begins}` : percent >= 100 ? `at ${shown.played ? "the " : ""}${ends}`
        : `${Math.round(percent)} % of the ${courseOf(exit)}`;
    controls.state.replaceChildren(...stateInWords(shown, stretch));
    controls.pointPlot();
    if (stage) {
        const hit = bodiesOf(shown, stretch.pairs);
        const isFree = !stretch.pairs.length && !stretch.outside && !!(shown.answer || shown.played);
        stage.place("solid", placed(SCENE, now));
        stage.colour(hit, isFree);
        stage.place("ghost", placed(SCENE, shown.q));
        stage.place("target", placed(SCENE, exit ? exit.witness : shown.q));
        stage.colourGhosts(bodiesOf(shown, collidingAt(shown)));
        // Contacts are of one place, so none are shown between the query and the exit.
        stage.showContacts(percent <= 0 ? shown.contacts : percent >= 100 && exit ? exit.contacts : NO_CONTACTS);
        byId("drawn").textContent = drawnInWords(shown, chosen, hit, isFree);
    }
    showNow(now);
    if (shown.slice) drawSlice(canvas, shown.slice, chosen, percent / 100, UNIT);
}

const NO_CONTACTS = [];

// The object of a grasp is the body after those of the scene.
const BODIES = SCENE.bodies.length;

function takeObject(object) {
    if (SCENE.bodies[BODIES] === object) return;
    SCENE.bodies.length = BODIES;
    if (object) SCENE.bodies.push(object);
    if (stage) stage.replace(BODIES, object);
}

// What depends on the query and the exit alone.
function showChosen() {
    const { shown, exit } = controls;
    takeObject(shown.object);
    if (stage) stage.lit = null;
    showNumbers(shown, exit);
    showJoints(shown, exit);
    byId("plane").hidden = !shown.slice;
    if (shown.slice) canvas.ariaLabel = caption.textContent = captionOf(shown.slice, exit, shown.slice.rings[0].length > 0);
}

// Shows some bodies alone, or all.
function light(bodies) {
    if (!stage) return;
    stage.lit = bodies && new Set(bodies);
    show();
}

// Turns the picture to the query that is shown, unless someone has turned it and it need not be.
function turnBack(always) {
    if (!stage || (stage.isTurned && !always)) return;
    const { shown } = controls;
    // Of a motion, some twenty of its frames.
    const step = Math.ceil(DATA.answers.length / 20);
    const others = DATA.stream ? DATA.answers.filter((_, at) => at % step === 0) : [];
    const ends = [shown, ...others].flatMap(({ q, exits }) => [
        q, ...exits.flatMap(({ way = [] }) => way.map(point => point.q)), ...exits.slice(0, 1).map(({ witness }) => witness),
    ]);
    chooseView(stage, ends.map(q => placed(SCENE, q)), bodiesOf(shown, collidingAt(shown)));
    stage.isTurned = false;
    stage.contacts = null;
    show();
}

function makeLegend() {
    const entries = [[COLOURS.hit, "collides"], [COLOURS.free, "free"], [COLOURS.plain, "other links"], [COLOURS.obstacle, "obstacles"]];
    const swatch = ([colour, text]) => {
        const box = element("i");
        box.style.background = `#${colour.toString(16).padStart(6, "0")}`;
        return element("span", {}, box, text);
    };
    byId("legend").replaceChildren(...entries.map(swatch));
}

const controls = new Controls(DATA.answers, { show, showChosen, onReset: turnBack });
const player = new Player(controls, DATA.stream);
document.title = `${DATA.title} \u2013 extricate`;
byId("title").textContent = DATA.title;
byId("made").textContent = DATA.made;
makeLegend();
listOfWords();
if (kinematicError(SCENE) > 1e-6) console.error("the page places links elsewhere than the library");
if (stage) {
    makeTree(stage, controls);
    makeTools(controls, stage, turnBack);
    followNames(stage);
    stage.onDraw = makeScale(stage);
    stage.resize();
}
if (DATA.answers.length) {
    controls.refresh();
    turnBack(true);
    const isLinked = takeHash(controls, stage);
    const isStill = DATA.stream || isLinked || matchMedia("(prefers-reduced-motion: reduce)").matches || !controls.shown.exits.length;
    if (!isStill) controls.open();
}
DARKNESS.addEventListener("change", () => {
    COLOURS = DARKNESS.matches ? DARK : LIGHT;
    makeLegend();
    if (stage) stage.repaint();
    if (DATA.answers.length) show();
});
// For scripts that drive the page.
window.extricate = { controls, player, stage, data: DATA, palettes: [LIGHT, DARK], ready: performance.now() };
if (DATA.live && DATA.answers.length) startLive();
