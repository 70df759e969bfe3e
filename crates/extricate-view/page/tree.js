// The bodies as a tree, each with a box that shows or hides it, and the layers of the picture.

const LAYERS = [
    { name: "solid", text: "links, as they are checked" },
    { name: "visuals", text: "visual meshes of links", key: "v" },
    { name: "stand_ins", text: "convex pieces of meshes, and balls in solids", key: "c" },
    { name: "ghost", text: "query, while the robot is elsewhere" },
    { name: "target", text: "exit" },
    { name: "obstacles", text: "obstacles" },
    { name: "contacts", text: "contacts" },
    { name: "grid", text: "grid" },
];

function checkbox(text, isOn, onChange) {
    const box = element("input", { type: "checkbox", checked: isOn });
    box.onchange = () => onChange(box.checked);
    return element("label", {}, box, element("span", {}, text));
}

// How many joints are above a frame.
function depthOf(frame) {
    return frame === 0 ? 0 : 1 + depthOf(SCENE.frames[frame].parent);
}

// The box of a layer; its key does the same.
function boxOf(stage, controls, { name, text, key }) {
    const isCoarse = name === "visuals" && SCENE.visuals.some(({ surface }) => surface.merged);
    const label = checkbox((isCoarse ? `${text}, more coarsely` : text) + (key ? ` (${key.toUpperCase()})` : ""), stage.layers[name].visible, isOn => {
        stage.showLayer(name, isOn);
        controls.show();
    });
    if (key) {
        controls.keys[key] = () => {
            label.firstChild.checked = !label.firstChild.checked;
            label.firstChild.onchange();
        };
    }
    return label;
}

function makeTree(stage, controls) {
    const layers = LAYERS.filter(({ name }) => stage.has(name)).map(layer => boxOf(stage, controls, layer));
    const details = element("details", {}, element("summary", {}, `Bodies and layers (${SCENE.bodies.length})`));
    // Scenes may have thousands of bodies, so they are listed when someone looks.
    details.addEventListener("toggle", () => {
        if (details.childElementCount > 1) return;
        details.append(element("h2", {}, "Layers"), ...layers, element("h2", {}, "Bodies"));
        SCENE.bodies.forEach((body, at) => {
            const label = checkbox(body.name, true, isOn => {
                if (isOn) stage.hidden.delete(at);
                else stage.hidden.add(at);
                controls.show();
            });
            label.style.paddingLeft = `${12 * Math.min(depthOf(body.frame), 10)}px`;
            details.append(label);
        });
    });
    byId("bodies").append(details);
}
