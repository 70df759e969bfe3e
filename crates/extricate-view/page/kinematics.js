// Where the frames of the scene are at a configuration. A pose is twelve numbers: the columns of the rotation, then the
// translation in m.

function composed(a, b) {
    const out = new Float64Array(12);
    for (let column = 0; column < 4; column++) {
        const [x, y, z] = [b[3 * column], b[3 * column + 1], b[3 * column + 2]];
        for (let row = 0; row < 3; row++) {
            out[3 * column + row] = a[row] * x + a[3 + row] * y + a[6 + row] * z + (column === 3 ? a[9 + row] : 0);
        }
    }
    return out;
}

const IDENTITY = Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0);

// Rodrigues' formula: a turn by an angle about a unit axis.
function turn([x, y, z], angle) {
    const [s, c] = [Math.sin(angle), Math.cos(angle)];
    const k = 1 - c;
    return Float64Array.of(
        c + k * x * x, k * x * y + s * z, k * x * z - s * y,
        k * x * y - s * z, c + k * y * y, k * y * z + s * x,
        k * x * z + s * y, k * y * z - s * x, c + k * z * z, 0, 0, 0);
}

function ofQuaternion([x, y, z, w]) {
    return Float64Array.of(
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0, 0, 0);
}

function motionOf(frame, q) {
    if (frame.motion === "ball") return ofQuaternion(q.slice(frame.q, frame.q + 4));
    const value = frame.factor * q[frame.q] + frame.offset;
    if (frame.motion === "revolute") return turn(frame.axis, value);
    return Float64Array.of(1, 0, 0, 0, 1, 0, 0, 0, 1, ...frame.axis.map(x => x * value));
}

// Poses of all frames; parents stand before their children.
function placed(scene, q) {
    const poses = [];
    for (const frame of scene.frames) {
        if (frame.motion === "world") poses.push(IDENTITY);
        else poses.push(composed(composed(poses[frame.parent], frame.pose), motionOf(frame, q)));
    }
    return poses;
}

function wrapped(angle) {
    return angle - 2 * Math.PI * Math.floor((angle + Math.PI) / (2 * Math.PI));
}

// The shorter way between two unit quaternions, at a fraction.
function slerp(a, b, t) {
    let dot = a.reduce((sum, x, k) => sum + x * b[k], 0);
    const sign = dot < 0 ? -1 : 1;
    dot = Math.min(1, Math.abs(dot));
    const angle = Math.acos(dot);
    const [u, v] = angle < 1e-9 ? [1 - t, t] : [Math.sin((1 - t) * angle), Math.sin(t * angle)].map(x => x / Math.sin(angle));
    const out = a.map((x, k) => u * x + sign * v * b[k]);
    const length = Math.hypot(...out);
    return out.map(x => x / length);
}

// The configuration at a fraction of the straight segment.
function between(scene, from, to, t) {
    if (t <= 0 || t >= 1) return (t <= 0 ? from : to).slice();
    const out = from.slice();
    for (const { manifold, q } of scene.factors) {
        if (manifold === "Rotation") {
            slerp(from.slice(q, q + 4), to.slice(q, q + 4), t).forEach((x, k) => { out[q + k] = x; });
        } else if (manifold === "Circle") {
            out[q] = wrapped(from[q] + t * wrapped(to[q] - from[q]));
        } else {
            out[q] = from[q] + t * (to[q] - from[q]);
        }
    }
    return out;
}

// The configuration at a fraction of the way to an exit: straight, or from waypoint to waypoint.
function along(scene, from, { way = [], witness }, t) {
    let [low, start] = [0, from];
    for (const { at, q } of [...way, { at: 1, q: witness }]) {
        if (t <= at) return between(scene, start, q, at > low ? (t - low) / (at - low) : 1);
        [low, start] = [at, q];
    }
    return witness.slice();
}

// The farthest that a frame is from where the library has it [m]: 0 but for rounding.
function kinematicError(scene) {
    const poses = placed(scene, scene.probe.q);
    const apart = scene.probe.origins.map((origin, at) => Math.hypot(...origin.map((x, k) => x - poses[at][9 + k])));
    return Math.max(0, ...apart);
}
