// What the words of the page mean: those of docs/reference/glossary.md, shorter.
const WORDS = {
    "configuration": "The positions of all joints, in rad or m.",
    "query": "The configuration that was given, and from which the nearest free one is wanted.",
    "free": "Every checked pair of bodies keeps at least the clearance, and every joint is within its limits. An exact "
        + "checker decides it, on the shapes themselves.",
    "exit": "A locally nearest free configuration: from here every small step toward the query collides.",
    "witness": "The nearest exit that was found: the answer.",
    "depth": "How far the witness is from the query, in the metric of the scene. The true depth is at most this.",
    "lower bound": "Proved: no free configuration is nearer to the query than this.",
    "gap": "The share of the depth that is not proved. At 0 % no free configuration is nearer than the witness.",
    "largest displacement": "How far any point of the robot moves at most between the query and the exit.",
    "in collision": "Pairs of bodies that are nearer than the clearance at the query.",
    "touching": "Pairs that are within 0.1 mm of their clearance at the exit: they hold the exit where it is.",
    "outside": "Joints of the query that are beyond their limits.",
    "verified": "The exact checker was run on the witness during this query and called it free.",
    "clearance": "The least distance that every checked pair keeps at the witness.",
    "unique": "Whether no other exit was met that is within 1 % as near.",
    "cut short": "A limit of checks or seconds ended the search, and over half of the depth is not proved.",
    "free radius": "Proved: nothing touches at any configuration nearer to the witness than this.",
    "unseen": "An estimate of the share of starts that would have led to an exit which this query has not met.",
    "effort": "How hard the query tried.",
    "checks": "How many collision checks and distances the query took.",
    "time": "How long the query took on the computer that answered it.",
    "metric": "How far two configurations are from each other. joint: the root of the sum of squared changes of the "
        + "joints. object-norm: how far the robot's volume moves in the mean. max-displacement: how far any point moves.",
    "contact": "Where two bodies touch at the exit, with the direction in which they part.",
    "waypoints": "Configurations of the path; between two of them it is straight.",
    "length": "From waypoint to waypoint, in the metric of the scene.",
    "proved free": "Segments between waypoints at every configuration of which nothing collides: proved, not sampled.",
    "undecided": "Segments that come so near to a contact that nothing is proved of them.",
    "first collision": "Where along the path something is known to collide for the first time.",
    "moved": "How far the released hand is from the query, in the metric of the scene.",
    "depth before": "How deep a link was inside the object at the query.",
    "touched": "Links that touched the object at the query, or were in it.",
    "kept": "Those of them that still touch it.",
    "kept sides": "Whether every contact is on the side of the object where its finger first touches as it closes.",
    "epsilon": "How well the object is held: the radius of the greatest ball of wrenches that the contacts resist.",
    "force closure": "Whether the contacts resist every wrench: proved where it says yes.",
    "slice": "A plane cut out of the space of all configurations. Each of its points is a configuration of all joints.",
};

// An element with text or other elements in it; names from files are text, never markup.
function element(tag, properties, ...children) {
    const made = document.createElement(tag);
    for (const [key, value] of Object.entries(properties || {})) {
        if (key in made && key !== "list") made[key] = value;
        else made.setAttribute(key, value);
    }
    made.append(...children);
    return made;
}

function byId(id) {
    return document.getElementById(id);
}

// A word that says what it means where it is pressed: a row is opened below its own.
function word(name, columns) {
    const button = element("button", { className: "word", type: "button", title: WORDS[name] }, name);
    button.setAttribute("aria-expanded", "false");
    button.onclick = () => {
        const row = button.closest("tr");
        const isOpen = row.nextSibling && row.nextSibling.className === "meaning";
        button.setAttribute("aria-expanded", String(!isOpen));
        if (isOpen) row.nextSibling.remove();
        else row.after(element("tr", { className: "meaning" }, element("td", { colSpan: columns }, WORDS[name])));
    };
    return button;
}

function listOfWords() {
    const list = element("dl");
    for (const [name, meaning] of Object.entries(WORDS)) {
        list.append(element("dt", {}, name), element("dd", {}, meaning));
    }
    const keys = [
        ["\u2190 \u2192", "along the exit"], ["Home End", "query, exit"], ["Space", "play"], ["A", "play all, or the motion"], ["1 to 9", "choose an exit"],
        ["N P", "next and previous query"], ["R", "turn the picture back"],
        ...LAYERS.filter(({ key }) => key).map(({ key, text }) => [key.toUpperCase(), text]),
        ["\u2190 \u2191 \u2192 \u2193 + \u2212", "turn and zoom, if the picture has the focus"],
    ];
    const rows = keys.map(([key, does]) => element("p", {}, element("kbd", {}, key), " " + does));
    byId("words").append(
        element("details", {}, element("summary", {}, "What the words mean"), list),
        element("details", {}, element("summary", {}, "Keys"), ...rows));
}
