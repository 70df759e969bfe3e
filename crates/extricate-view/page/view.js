// Where the picture is looked at from: of some azimuths the one from which the links that collide are hidden least.

const AZIMUTHS = 16;
// Elevations [rad]; the later ones are tried where the links that collide are hidden from all azimuths of the first.
const ELEVATIONS = [0.42, 0.95, -0.15];
// Size of the pictures that are compared, and how many of their pixels have to be seen [px].
const [TRIAL_WIDTH, TRIAL_HEIGHT, ENOUGH_PIXELS] = [192, 144, 60];

// What a pixel of the other links counts beside one of those that collide.
const OTHERS_WEIGHT = 0.06;

// Corners of the box around what moves, at several poses.
function cornersOf(stage, places) {
    const box = { low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
    for (const poses of places) {
        for (const { geometry, body } of stage.bodies.filter(made => made && made.moves)) {
            const [positions, pose] = [geometry.attributes.position.array, poses[body.frame]];
            const step = 3 * Math.ceil(positions.length / 3000);
            for (let at = 0; at < positions.length; at += step) {
                for (let k = 0; k < 3; k++) {
                    const x = pose[k] * positions[at] + pose[3 + k] * positions[at + 1] + pose[6 + k] * positions[at + 2] + pose[9 + k];
                    box.low[k] = Math.min(box.low[k], x);
                    box.high[k] = Math.max(box.high[k], x);
                }
            }
        }
    }
    return box.low[0] <= box.high[0] ? box : { low: [-0.5, -0.5, 0], high: [0.5, 0.5, 1] };
}

// Draws the links in `hit` red and the others green, and returns a function from a view to the red and the green that are seen [px].
function trialOf(stage, hit) {
    const target = new THREE.WebGLRenderTarget(TRIAL_WIDTH, TRIAL_HEIGHT);
    const pixels = new Uint8Array(4 * TRIAL_WIDTH * TRIAL_HEIGHT);
    // Materials as those of the picture, so that no shader is compiled for them.
    const looks = { hit: material(0, 1), other: material(0, 1), veil: material(0, 0.42) };
    looks.hit.emissive.set(0xff0000);
    looks.other.emissive.set(0x00ff00);
    const camera = stage.camera.clone();
    camera.aspect = TRIAL_WIDTH / TRIAL_HEIGHT;
    const put = isTrial => {
        for (const made of stage.bodies.filter(made => made)) {
            for (const cloud of made.clouds || []) cloud.material.color.set(isTrial ? 0 : COLOURS.obstacle);
            if (!made.mesh) continue;
            if (isTrial) made.look = made.mesh.material;
            made.mesh.material = !isTrial ? made.look : !made.moves ? looks.veil : hit.has(made.at) ? looks.hit : looks.other;
            if (made.edges) made.edges.visible = !isTrial;
        }
        for (const [name, layer] of Object.entries(stage.layers)) {
            if (isTrial) wasShown[name] = layer.visible;
            layer.visible = isTrial ? ["solid", "obstacles"].includes(name) : wasShown[name];
        }
        stage.world.background.set(isTrial ? 0 : COLOURS.back);
    };
    const wasShown = {};
    const seen = () => {
        camera.position.copy(stage.camera.position);
        camera.quaternion.copy(stage.camera.quaternion);
        Object.assign(camera, { near: stage.camera.near, far: stage.camera.far });
        camera.updateProjectionMatrix();
        camera.updateMatrixWorld();
        stage.renderer.setRenderTarget(target);
        stage.renderer.render(stage.world, camera);
        stage.renderer.readRenderTargetPixels(target, 0, 0, TRIAL_WIDTH, TRIAL_HEIGHT, pixels);
        stage.renderer.setRenderTarget(null);
        const sums = [0, 0];
        for (let at = 0; at < pixels.length; at += 4) {
            sums[0] += pixels[at] / 255;
            sums[1] += pixels[at + 1] / 255;
        }
        return sums;
    };
    put(true);
    return { seen, end: () => { put(false); target.dispose(); Object.values(looks).forEach(look => look.dispose()); } };
}

// How far the links in `hit` move in the mean between two poses of the frames.
function motionBetween(stage, hit, from, to) {
    const moved = [0, 0, 0];
    for (const made of stage.bodies.filter(made => made && made.moves && hit.has(made.at))) {
        const { boundingSphere: { center } } = made.geometry;
        const place = pose => [0, 1, 2].map(k => pose[k] * center.x + pose[3 + k] * center.y + pose[6 + k] * center.z + pose[9 + k]);
        const [a, b] = [from, to].map(poses => place(poses[made.body.frame]));
        a.forEach((x, k) => { moved[k] += b[k] - x; });
    }
    return new THREE.Vector3(...moved);
}

// Looks at what moves so that the links in `hit` are seen, and their way to the exit from its side. The robot stands at the
// first of `places`.
function chooseView(stage, places, hit) {
    const { low, high } = cornersOf(stage, places);
    stage.radius = Math.max(1e-3, Math.hypot(...high.map((x, k) => x - low[k])) / 2);
    const half = stage.camera.fov * Math.PI / 360;
    const narrow = Math.atan(Math.tan(half) * Math.min(1, stage.camera.aspect));
    const distance = 1.02 * stage.radius / Math.sin(narrow);
    Object.assign(stage.camera, { near: distance / 200, far: distance * 40 });
    stage.camera.updateProjectionMatrix();
    stage.orbit.target.set(...low.map((x, k) => (x + high[k]) / 2));
    stage.drawGrid(low[2]);
    stage.place("solid", places[0]);
    const moved = motionBetween(stage, hit, places[0], places[places.length - 1]);
    const trial = trialOf(stage, hit);
    let best = { score: -1 };
    for (const elevation of ELEVATIONS) {
        if (best.pixels > ENOUGH_PIXELS || (!hit.size && best.score >= 0)) break;
        for (let k = 0; k < AZIMUTHS; k++) {
            const azimuth = 2.2 + 2 * Math.PI * k / AZIMUTHS;
            stage.lookFrom(azimuth, elevation, distance);
            stage.camera.updateMatrixWorld();
            const [pixels, others] = hit.size ? trial.seen() : [0, 0];
            const along = stage.camera.getWorldDirection(new THREE.Vector3()).dot(moved) / (moved.length() || 1);
            const score = (pixels + OTHERS_WEIGHT * others) * (0.5 + 0.5 * Math.sqrt(1 - Math.min(1, along * along)));
            if (score > best.score) best = { score, pixels, azimuth, elevation };
            if (!hit.size) break;
        }
    }
    trial.end();
    stage.lookFrom(best.azimuth, best.elevation, distance);
}

// The view as text, for links: where the camera is, and at what it looks [m].
function viewAsText(stage) {
    return [...stage.camera.position.toArray(), ...stage.orbit.target.toArray()].map(x => Number(x.toPrecision(5))).join(",");
}

function takeView(stage, text) {
    const numbers = text.split(",").map(Number);
    if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return;
    stage.camera.position.set(...numbers.slice(0, 3));
    stage.orbit.target.set(...numbers.slice(3));
    stage.isTurned = true;
    stage.orbit.update();
    stage.render();
}

// The axes of the world and the side of a square of the grid, in the corner of the picture.
function makeScale(stage) {
    const side = 56;
    const canvas = element("canvas", { width: 2 * side, height: 2 * side, style: `width: ${side}px; height: ${side}px` });
    const text = element("span");
    byId("scale").append(canvas, text);
    const context = canvas.getContext("2d");
    let shown = "";
    return () => {
        const now = [stage.layers.grid.visible, stage.cell, ...stage.camera.quaternion.toArray()].join();
        if (now === shown) return;
        shown = now;
        text.textContent = stage.layers.grid.visible ? `squares of ${digits(stage.cell)} m` : "";
        context.clearRect(0, 0, 2 * side, 2 * side);
        const axes = [["x", 1, 0, 0, "#c24e00"], ["y", 0, 1, 0, "#00866b"], ["z", 0, 0, 1, "#2f86c1"]].map(([name, x, y, z, colour]) => {
            const seen = new THREE.Vector3(x, y, z).applyQuaternion(stage.camera.quaternion.clone().invert());
            return { name, colour, seen };
        });
        // What points away from the eye is drawn first.
        for (const { name, colour, seen } of axes.sort((a, b) => a.seen.z - b.seen.z)) {
            const [x, y] = [side + 36 * seen.x, side - 36 * seen.y];
            context.strokeStyle = context.fillStyle = colour;
            context.lineWidth = 4;
            context.beginPath();
            context.moveTo(side, side);
            context.lineTo(x, y);
            context.stroke();
            context.font = "600 22px system-ui, sans-serif";
            context.textAlign = "center";
            context.textBaseline = "middle";
            context.fillText(name, side + 48 * seen.x, side - 48 * seen.y);
        }
    };
}

// The name of the body under the pointer, beside it.
function followNames(stage) {
    const [picture, note] = [stage.renderer.domElement, byId("name")];
    let event = null;
    const look = () => {
        const hit = event && !event.buttons ? stage.bodyAt(event) : null;
        note.hidden = !hit;
        if (hit) {
            const box = stage.host.getBoundingClientRect();
            const name = stage.scene.bodies[hit.body].name;
            note.textContent = name;
            const left = Math.max(12, Math.min(event.clientX - box.left + 14, box.width - note.offsetWidth - 12));
            Object.assign(note.style, { left: `${left}px`, top: `${Math.max(4, event.clientY - box.top - 30)}px` });
        }
        event = null;
    };
    picture.addEventListener("pointermove", moved => {
        if (!event) requestAnimationFrame(look);
        event = moved;
    });
    picture.addEventListener("pointerleave", () => {
        event = null;
        note.hidden = true;
    });
}
