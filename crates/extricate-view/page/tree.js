// The bodies as a tree, each with a box that shows or hides it, and the layers of the picture.

const LAYERS = { ghost: "query, while the robot is elsewhere", target: "exit", obstacles: "obstacles", contacts: "contacts", grid: "grid" };

function checkbox(text, isOn, onChange) {
    const box = element("input", { type: "checkbox", checked: isOn });
    box.onchange = () => onChange(box.checked);
    return element("label", {}, box, element("span", {}, text));
}

// How many joints are above a frame.
function depthOf(frame) {
    return frame === 0 ? 0 : 1 + depthOf(SCENE.frames[frame].parent);
}

function makeTree(stage, changed) {
    const layers = Object.entries(LAYERS).map(([name, text]) => checkbox(text, true, isOn => {
        stage.layers[name].visible = isOn;
        changed();
    }));
    const details = element("details", {}, element("summary", {}, `Bodies and layers (${SCENE.bodies.length})`));
    // Scenes may have thousands of bodies, so they are listed when someone looks.
    details.addEventListener("toggle", () => {
        if (details.childElementCount > 1) return;
        details.append(element("h2", {}, "Layers"), ...layers, element("h2", {}, "Bodies"));
        SCENE.bodies.forEach((body, at) => {
            const label = checkbox(body.name, true, isOn => {
                if (isOn) stage.hidden.delete(at);
                else stage.hidden.add(at);
                changed();
            });
            label.style.paddingLeft = `${12 * Math.min(depthOf(body.frame), 10)}px`;
            details.append(label);
        });
    });
    byId("bodies").append(details);
}
