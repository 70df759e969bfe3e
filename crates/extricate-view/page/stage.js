// The picture: bodies, ghosts and contacts. What is shown where is decided by others.

const LIGHT = {
    hit: 0xd55e00, free: 0x2f86c1, plain: 0x93a1b3, obstacle: 0xc8bfa6, edge: 0x5d5745, ghost: 0x7d8794, contact: 0x111111,
    back: 0xeef1f5, grid: 0xd8dde4, middle: 0xb9c1cc,
};
const DARK = {
    hit: 0xe8690a, free: 0x3d97d3, plain: 0x9aa8bb, obstacle: 0x857d66, edge: 0xb9b094, ghost: 0x8b95a3, contact: 0xffffff,
    back: 0x12161c, grid: 0x262d37, middle: 0x3a4452,
};
const DARKNESS = matchMedia("(prefers-color-scheme: dark)");
let COLOURS = DARKNESS.matches ? DARK : LIGHT;

// Points and voxels of a body above which each is one square, not a solid.
const MOST_SOLIDS = 4000;

function bytesOf(text) {
    return Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
}

function inBox(text, low, side) {
    return Float32Array.from(new Uint16Array(bytesOf(text)), (x, at) => low[at % 3] + side[at % 3] * x / 65535);
}

function geometryOf({ low, side, vertices, triangles, wide }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(inBox(vertices, low, side), 3));
    const corners = bytesOf(triangles);
    geometry.setIndex(new THREE.BufferAttribute(wide ? new Uint32Array(corners) : new Uint16Array(corners), 1));
    return faceted(geometry);
}

// Corners of their own for every triangle, with its normal: a shade is one of a triangle.
function faceted(geometry) {
    const facets = geometry.toNonIndexed();
    facets.computeVertexNormals();
    return facets;
}

// The light of Lambert's law on the side that is seen, in the colours of the screen. It is computed for corners, not for pixels,
// of which a processor has to draw a million.
const SHADE = {
    vertexShader: `
        uniform vec3 diffuse, emissive;
        varying vec3 shade;
        #include <common>
        #include <colorspace_pars_fragment>
        #include <lights_pars_begin>
        void main() {
            #include <beginnormal_vertex>
            #include <defaultnormal_vertex>
            #include <begin_vertex>
            #include <project_vertex>
            vec3 outward = normalize(transformedNormal);
            vec3 normal = dot(outward, mvPosition.xyz) > 0.0 ? -outward : outward;
            vec3 light = getHemisphereLightIrradiance(hemisphereLights[0], normal)
                + saturate(dot(normal, directionalLights[0].direction)) * directionalLights[0].color;
            shade = sRGBTransferOETF(vec4(emissive + RECIPROCAL_PI * diffuse * light, 1.0)).rgb;
        }`,
    fragmentShader: `
        uniform float opacity;
        varying vec3 shade;
        void main() {
            gl_FragColor = vec4(shade, opacity);
        }`,
};

function material(colour, opacity) {
    const made = new THREE.MeshLambertMaterial({
        color: colour, opacity, transparent: opacity < 1, depthWrite: opacity === 1, side: THREE.DoubleSide,
        // Without this, what is translucent is drawn twice, and its shader is looked up anew for every picture.
        forceSinglePass: true,
    });
    made.onBeforeCompile = shader => Object.assign(shader, SHADE);
    return made;
}

// Milliseconds without a change after which a picture is at rest.
const REST = 250;

// Whether pictures are drawn by the processor, which is too slow for smooth edges while something moves.
function isDrawnByProcessor() {
    const gl = element("canvas").getContext("webgl2");
    const info = gl && gl.getExtension("WEBGL_debug_renderer_info");
    return !!info && /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(info.UNMASKED_RENDERER_WEBGL));
}

// Points or voxels: solids, or squares if they are many.
function cloudOf({ pose, low, side, centres, size, cubes }) {
    const places = inBox(centres, low, side);
    const count = places.length / 3;
    const width = size || 0.004;
    let cloud;
    if (count > MOST_SOLIDS) {
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
        // Shades set neighbours apart.
        const shades = Float32Array.from({ length: 3 * count }, (_, at) => 0.7 + 0.3 * ((Math.floor(at / 3) * 0.618) % 1));
        geometry.setAttribute("color", new THREE.BufferAttribute(shades, 3));
        cloud = new THREE.Points(geometry, new THREE.PointsMaterial({ color: COLOURS.obstacle, size: width, vertexColors: true }));
    } else {
        const shape = cubes ? new THREE.BoxGeometry(width, width, width) : new THREE.SphereGeometry(width / 2, 6, 4);
        cloud = new THREE.InstancedMesh(faceted(shape), material(COLOURS.obstacle, 1), count);
        const matrix = new THREE.Matrix4();
        for (let at = 0; at < count; at++) cloud.setMatrixAt(at, matrix.makeTranslation(...places.subarray(3 * at, 3 * at + 3)));
    }
    cloud.matrixAutoUpdate = false;
    setPose(cloud, pose);
    return cloud;
}

function setPose(object, pose) {
    const [a, b, c, d, e, f, g, h, i, x, y, z] = pose;
    object.matrix.set(a, d, g, x, b, e, h, y, c, f, i, z, 0, 0, 0, 1);
    object.matrixWorldNeedsUpdate = true;
}

// How links look: shapes in the colours of their materials.
function visualsOf({ visuals }) {
    return visuals.map(({ body, frame, colour, surface }) => {
        const mesh = new THREE.Mesh(geometryOf(surface), material(0, 1));
        mesh.userData.body = body;
        return { body, frame, colour, mesh, group: groupOf(mesh) };
    });
}

// What stands for shapes in quick tests: edges of the convex pieces of meshes, and balls in solids.
function standInsOf({ bodies, stand_ins: all }) {
    return all.map(({ body, balls, pieces }) => {
        const spheres = new THREE.InstancedMesh(faceted(new THREE.SphereGeometry(1, 16, 10)), material(COLOURS.contact, 0.25), balls.length);
        balls.forEach(([x, y, z, r], at) => spheres.setMatrixAt(at, new THREE.Matrix4().set(r, 0, 0, x, 0, r, 0, y, 0, 0, r, z, 0, 0, 0, 1)));
        const edges = pieces ? [new THREE.LineSegments(
            new THREE.EdgesGeometry(geometryOf(pieces), 1), new THREE.LineBasicMaterial({ color: COLOURS.contact }))] : [];
        return { body, frame: bodies[body].frame, group: groupOf(spheres, ...edges) };
    });
}

// Layers that few people look at are made when they are shown.
const EXTRAS = { visuals: visualsOf, stand_ins: standInsOf };

function groupOf(...parts) {
    const group = new THREE.Group();
    group.matrixAutoUpdate = false;
    group.add(...parts);
    return group;
}

class Stage {
    constructor(host, scene) {
        Object.assign(this, { host, scene, hidden: new Set(), lit: null, radius: 1, extras: [], poses: [], onDraw: () => {} });
        this.world = new THREE.Scene();
        this.world.background = new THREE.Color(COLOURS.back);
        this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
        this.camera.up.set(0, 0, 1);
        this.isSlow = isDrawnByProcessor();
        // Nothing shines through the picture, so the browser need not blend it with the page.
        const canvas = element("canvas");
        const context = canvas.getContext("webgl2", { alpha: false, antialias: !this.isSlow });
        this.renderer = new THREE.WebGLRenderer({ canvas, context });
        this.sharpen(true);
        const picture = this.renderer.domElement;
        host.append(picture);
        picture.tabIndex = 0;
        picture.setAttribute("aria-label", "Picture. Drag to turn, scroll or pinch to zoom; or use the arrow keys, + and \u2212");
        picture.addEventListener("keydown", event => this.key(event));
        this.orbit = new THREE.OrbitControls(this.camera, picture);
        this.orbit.addEventListener("change", () => this.render());
        // Whoever has turned the picture keeps it as it is.
        this.orbit.addEventListener("start", () => { this.isTurned = true; });
        const sun = new THREE.DirectionalLight(0xffffff, 1.9);
        sun.position.set(0.5, -0.6, 1.4);
        this.world.add(new THREE.HemisphereLight(0xffffff, 0x9aa3b0, 1.9), sun);
        this.layers = {};
        for (const { name } of LAYERS) {
            this.layers[name] = new THREE.Group();
            this.layers[name].visible = !(name in EXTRAS);
            this.world.add(this.layers[name]);
        }
        this.bodies = scene.bodies.map((body, at) => this.makeBody(body, at));
        new ResizeObserver(() => this.resize()).observe(host);
    }

    makeBody(body, at) {
        if (!body.surface && !body.clouds) return null;
        const made = { at, body, moves: body.frame !== 0 || body.link };
        made.geometry = body.surface ? geometryOf(body.surface) : null;
        const add = (layer, ...parts) => {
            for (const part of parts) part.userData.body = at;
            const group = groupOf(...parts);
            this.layers[layer].add(group);
            return group;
        };
        // After obstacles, which write no depth: a ghost in one is still seen.
        const ghost = colour => Object.assign(new THREE.Mesh(made.geometry, material(colour, 0.28)), { renderOrder: 1 });
        if (made.moves && made.geometry) {
            made.mesh = new THREE.Mesh(made.geometry, material(COLOURS.plain, 1));
            made.geometry.computeBoundingSphere();
            made.reach = made.geometry.boundingSphere.radius + made.geometry.boundingSphere.center.length();
            made.solid = add("solid", made.mesh);
            for (const name of ["ghost", "target"]) {
                made[name] = add(name, ghost(name === "ghost" ? COLOURS.ghost : COLOURS.free));
                // The robot wins where both have the same surface.
                Object.assign(made[name].children[0].material,
                    { depthWrite: true, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8 });
            }
            return made;
        }
        const parts = (body.clouds || []).map(cloudOf);
        made.clouds = parts.slice();
        if (made.geometry) {
            made.mesh = new THREE.Mesh(made.geometry, material(COLOURS.obstacle, 0.42));
            made.edges = new THREE.LineSegments(
                new THREE.EdgesGeometry(made.geometry, 30), new THREE.LineBasicMaterial({ color: COLOURS.edge }));
            parts.push(made.mesh, made.edges);
        }
        made.solid = add("obstacles", ...parts);
        made.moves = false;
        return made;
    }

    // Whether the scene has anything for a layer.
    has(name) {
        return !(name in EXTRAS) || this.scene[name].length > 0;
    }

    // Whether the picture shows anything of a layer.
    draws(name) {
        return this.layers[name].visible && this.layers[name].children.some(part => part.visible);
    }

    showLayer(name, isOn) {
        this.layers[name].visible = isOn;
        if (!isOn || !(name in EXTRAS) || this.layers[name].children.length) return;
        const made = EXTRAS[name](this.scene);
        this.layers[name].add(...made.map(({ group }) => group));
        this.extras.push(...made);
        this.placeExtras();
    }

    placeExtras() {
        for (const { body, frame, group } of this.extras) setPose(group, (this.bodies[body] || {}).pose || this.poses[frame]);
    }

    // Puts a body in the place of another, or none.
    replace(at, body) {
        const made = this.bodies[at];
        if (made) made.solid.removeFromParent();
        this.bodies[at] = body ? this.makeBody(body, at) : null;
    }

    // Bodies at these poses of frames, in one of the layers `solid`, `ghost` and `target`.
    place(layer, poses) {
        for (const made of this.bodies) {
            if (!made || !made.moves) continue;
            setPose(made[layer], poses[made.body.frame]);
            if (layer === "solid") continue;
            // A ghost in about the place of the robot only flickers.
            const [own, other] = [made[layer].matrix.elements, made.solid.matrix.elements];
            const moved = own.reduce((most, x, k) => Math.max(most, Math.abs(x - other[k]) * (k < 12 ? made.reach : 1)), 0);
            made[layer].visible = !this.hidden.has(made.at) && moved > 0.005 * this.radius;
        }
        if (layer === "solid") {
            this.poses = poses;
            this.placeExtras();
        }
        this.render();
    }

    // Colours of the robot: what collides, and whether nothing does. The edges of obstacles change, so that links inside of
    // them stand out. If some bodies are lit, the others fade.
    colour(hit, isFree) {
        const isThrough = Object.keys(EXTRAS).some(name => this.layers[name].visible);
        for (const { body, colour, mesh, group } of this.extras) {
            group.visible = !this.hidden.has(body);
            if (mesh) mesh.material.color.set(hit.has(body) ? COLOURS.hit : colour === null ? COLOURS.plain : colour);
        }
        for (const made of this.bodies) {
            if (!made) continue;
            const [isHit, isDim] = [hit.has(made.at), this.lit && !this.lit.has(made.at)];
            made.solid.visible = !this.hidden.has(made.at);
            if (made.moves) {
                const look = made.mesh.material;
                look.color.set(isHit ? COLOURS.hit : isFree ? COLOURS.free : COLOURS.plain);
                look.opacity = isDim ? 0.12 : isThrough ? 0.35 : 1;
                const isThin = !!(isDim || isThrough);
                // The shader of what is solid takes no opacity.
                if (look.transparent !== isThin) Object.assign(look, { transparent: isThin, depthWrite: !isThin, needsUpdate: true });
                continue;
            }
            // A cloud that collides in one place keeps its colour, unless its pair is lit.
            for (const cloud of made.clouds) {
                cloud.material.color.set(isHit && this.lit ? COLOURS.hit : COLOURS.obstacle);
                cloud.visible = !isDim;
            }
            if (!made.mesh) continue;
            made.mesh.material.color.set(COLOURS.obstacle);
            made.mesh.material.opacity = isDim ? 0.1 : this.lit ? 0.65 : 0.42;
            made.edges.material.color.set(isHit ? COLOURS.hit : COLOURS.edge);
            made.edges.visible = !isDim;
        }
    }

    colourGhosts(hit) {
        for (const made of this.bodies) {
            if (!made || !made.moves) continue;
            const [ghost, target] = [made.ghost, made.target].map(group => group.children[0].material);
            const isHit = hit.has(made.at);
            ghost.color.set(isHit ? COLOURS.hit : COLOURS.ghost);
            ghost.opacity = isHit ? 0.5 : 0.22;
            target.color.set(COLOURS.free);
        }
    }

    // A point and an arrow for each contact, along which its first body parts from its second.
    showContacts(contacts) {
        if (contacts === this.contacts) return;
        this.contacts = contacts;
        this.layers.contacts.clear();
        const size = 0.16 * this.radius;
        for (const { point_second: from, normal } of contacts) {
            const arrow = new THREE.ArrowHelper(
                new THREE.Vector3(...normal), new THREE.Vector3(...from), size, COLOURS.contact, 0.3 * size, 0.16 * size);
            const ball = new THREE.Mesh(faceted(new THREE.SphereGeometry(0.07 * size, 12, 8)), material(COLOURS.contact, 1));
            ball.position.set(...from);
            for (const part of [arrow.line, arrow.cone, ball]) {
                // After what is translucent, and through everything: contacts are mostly hidden between two bodies.
                Object.assign(part.material, { depthTest: false, transparent: true });
                part.renderOrder = 2;
            }
            this.layers.contacts.add(arrow, ball);
        }
    }

    // Squares of a tenth of a metre, or of another power of ten, below what moves.
    drawGrid(height) {
        this.layers.grid.clear();
        const cell = 10 ** Math.round(Math.log10(this.radius / 6));
        const count = 2 * Math.ceil(2.2 * this.radius / cell);
        const grid = new THREE.GridHelper(cell * count, count, COLOURS.middle, COLOURS.grid);
        grid.rotation.x = Math.PI / 2;
        grid.position.set(this.orbit.target.x, this.orbit.target.y, Math.min(0, height) - 1e-3 * this.radius);
        grid.position.x -= grid.position.x % cell;
        grid.position.y -= grid.position.y % cell;
        this.layers.grid.add(grid);
        Object.assign(this, { cell, height });
    }

    // In the colours of the day or of the night. Bodies take theirs when they are coloured next.
    repaint() {
        this.world.background.set(COLOURS.back);
        this.drawGrid(this.height);
        this.contacts = null;
        this.extras = [];
        for (const name of Object.keys(EXTRAS)) {
            this.layers[name].clear();
            this.showLayer(name, this.layers[name].visible);
        }
    }

    // Puts an obstacle away from where the scene has it, by a vector [m].
    shift(body, by) {
        const made = this.bodies[body];
        if (!made) return;
        made.pose = [...IDENTITY.slice(0, 9), ...by];
        setPose(made.solid, made.pose);
        this.placeExtras();
        this.render();
    }

    rayOf(event) {
        const box = this.renderer.domElement.getBoundingClientRect();
        const place = new THREE.Vector2(
            2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
        const ray = new THREE.Raycaster();
        ray.params.Points.threshold = 0.01 * this.radius;
        ray.setFromCamera(place, this.camera);
        return ray;
    }

    // The first body under the pointer that is shown, and where.
    bodyAt(event) {
        const groups = [...this.bodies.filter(made => made).map(({ solid }) => solid), ...this.layers.visuals.children];
        const shown = groups.filter(group => group.visible && group.parent.visible);
        const parts = shown.flatMap(group => group.children.filter(part => !part.isLineSegments && part.userData.body !== null));
        const [hit] = this.rayOf(event).intersectObjects(parts, false);
        return hit ? { body: hit.object.userData.body, point: hit.point.toArray() } : null;
    }

    // Where the pointer is in the level plane through a point, or in the upright one that faces the camera.
    pointInPlane(event, point, upright) {
        const normal = upright ? this.camera.getWorldDirection(new THREE.Vector3()).setZ(0).normalize() : new THREE.Vector3(0, 0, 1);
        const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, new THREE.Vector3(...point));
        const found = this.rayOf(event).ray.intersectPlane(plane, new THREE.Vector3());
        return found ? found.toArray() : null;
    }

    // Turns and zooms by keys, if the picture has the focus.
    key(event) {
        const [turn, zoom] = [0.12, 1.1];
        const steps = {
            ArrowLeft: [-turn, 0, 1], ArrowRight: [turn, 0, 1], ArrowUp: [0, turn, 1], ArrowDown: [0, -turn, 1],
            "+": [0, 0, 1 / zoom], "-": [0, 0, zoom],
        };
        const step = steps[event.key];
        if (!step || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        event.stopPropagation();
        const away = this.camera.position.clone().sub(this.orbit.target);
        const azimuth = Math.atan2(away.y, away.x) + step[0];
        const elevation = Math.max(-1.5, Math.min(1.5, Math.asin(away.z / away.length()) + step[1]));
        this.isTurned = true;
        this.lookFrom(azimuth, elevation, away.length() * step[2]);
    }

    lookFrom(azimuth, elevation, distance) {
        const [up, out] = [Math.sin(elevation), Math.cos(elevation)];
        this.camera.position.set(out * Math.cos(azimuth), out * Math.sin(azimuth), up).multiplyScalar(distance).add(this.orbit.target);
        this.orbit.update();
        this.render();
    }

    resize() {
        const [width, height] = [this.host.clientWidth, this.host.clientHeight];
        if (!width || !height || (width === this.width && height === this.height)) return;
        const isFirst = !this.width;
        Object.assign(this, { width, height });
        this.renderer.setSize(width, height, false);
        Object.assign(this.renderer.domElement.style, { width: "100%", height: "100%" });
        this.camera.aspect = width / height;
        this.camera.updateProjectionMatrix();
        // Another size clears the picture, so it is drawn at once. Nothing is shown before the first.
        if (isFirst) this.render();
        else this.draw();
    }

    // Once a frame at most, and only where something changed.
    render() {
        if (this.due) return;
        this.due = requestAnimationFrame(() => this.drawAt(false));
        clearTimeout(this.later);
        if (this.isSlow) this.later = setTimeout(() => this.drawAt(true), REST);
    }

    drawAt(isSharp) {
        this.sharpen(isSharp);
        this.draw();
    }

    // A graphics card always draws as many pixels as the screen has. The processor draws one for each of the page, or four.
    sharpen(isSharp) {
        const ratio = !this.isSlow ? Math.min(devicePixelRatio, 2) : isSharp ? 2 : 1;
        if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
    }

    draw() {
        cancelAnimationFrame(this.due);
        this.due = null;
        this.renderer.render(this.world, this.camera);
        this.onDraw();
    }
}
