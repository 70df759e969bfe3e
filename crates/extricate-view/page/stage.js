// The picture: bodies, ghosts and contacts. What is shown where is decided by others.

const COLOURS = {
    hit: 0xd55e00, free: 0x2f86c1, plain: 0x93a1b3, obstacle: 0xc8bfa6, edge: 0x5d5745, ghost: 0x7d8794, contact: 0x111111,
};

function bytesOf(text) {
    return Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;
}

function geometryOf({ low, side, vertices, triangles, wide }) {
    const numbers = new Uint16Array(bytesOf(vertices));
    const positions = Float32Array.from(numbers, (x, at) => low[at % 3] + side[at % 3] * x / 65535);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    const corners = bytesOf(triangles);
    geometry.setIndex(new THREE.BufferAttribute(wide ? new Uint32Array(corners) : new Uint16Array(corners), 1));
    return geometry;
}

function material(colour, opacity) {
    return new THREE.MeshLambertMaterial({
        color: colour, opacity, transparent: opacity < 1, depthWrite: opacity === 1, flatShading: true, side: THREE.DoubleSide,
    });
}

function setPose(object, pose) {
    const [a, b, c, d, e, f, g, h, i, x, y, z] = pose;
    object.matrix.set(a, d, g, x, b, e, h, y, c, f, i, z, 0, 0, 0, 1);
    object.matrixWorldNeedsUpdate = true;
}

class Stage {
    constructor(host, scene) {
        this.host = host;
        this.scene = scene;
        this.world = new THREE.Scene();
        this.world.background = new THREE.Color(0xeef1f5);
        this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
        this.camera.up.set(0, 0, 1);
        this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
        this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        host.append(this.renderer.domElement);
        this.orbit = new THREE.OrbitControls(this.camera, this.renderer.domElement);
        this.orbit.addEventListener("change", () => this.render());
        // Whoever has turned the picture keeps it as it is.
        this.orbit.addEventListener("start", () => { this.isTurned = true; });
        const sun = new THREE.DirectionalLight(0xffffff, 1.9);
        sun.position.set(0.5, -0.6, 1.4);
        this.world.add(new THREE.HemisphereLight(0xffffff, 0x9aa3b0, 1.9), sun);
        this.layers = {};
        for (const name of ["solid", "ghost", "target", "obstacles", "contacts", "grid"]) {
            this.layers[name] = new THREE.Group();
            this.world.add(this.layers[name]);
        }
        this.layers.target.visible = false;
        this.bodies = scene.bodies.map((body, at) => this.makeBody(body, at));
        new ResizeObserver(() => this.resize()).observe(host);
    }

    makeBody(body, at) {
        if (!body.surface) return null;
        const geometry = geometryOf(body.surface);
        const moves = body.frame !== 0 || body.link;
        const made = { at, body, geometry, moves };
        const add = (layer, colour, opacity) => {
            const mesh = new THREE.Mesh(geometry, material(colour, opacity));
            mesh.matrixAutoUpdate = false;
            mesh.userData.body = at;
            layer.add(mesh);
            return mesh;
        };
        if (moves) {
            made.solid = add(this.layers.solid, COLOURS.plain, 1);
            made.ghost = add(this.layers.ghost, COLOURS.ghost, 0.2);
            made.target = add(this.layers.target, COLOURS.free, 0.2);
        } else {
            made.solid = add(this.layers.obstacles, COLOURS.obstacle, 0.42);
            const edges = new THREE.EdgesGeometry(geometry, 30);
            made.edges = new THREE.LineSegments(edges, new THREE.LineBasicMaterial({ color: COLOURS.edge }));
            made.edges.matrixAutoUpdate = false;
            this.layers.obstacles.add(made.edges);
        }
        return made;
    }

    // Bodies at these poses of frames, in one of the layers `solid`, `ghost` and `target`.
    place(layer, poses) {
        for (const made of this.bodies) {
            if (made && made.moves) setPose(made[layer], poses[made.body.frame]);
        }
        this.render();
    }

    // Colours of the solid robot: what collides, and whether nothing does. Of obstacles the edges change, so that links
    // that are inside of them stand out.
    colour(hit, isFree) {
        for (const made of this.bodies) {
            if (!made) continue;
            const isHit = hit.has(made.at);
            if (made.moves) made.solid.material.color.set(isHit ? COLOURS.hit : isFree ? COLOURS.free : COLOURS.plain);
            else made.edges.material.color.set(isHit ? COLOURS.hit : COLOURS.edge);
        }
    }

    colourGhost(hit) {
        for (const made of this.bodies) {
            if (!made || !made.ghost) continue;
            const isHit = hit.has(made.at);
            made.ghost.material.color.set(isHit ? COLOURS.hit : COLOURS.ghost);
            made.ghost.material.opacity = isHit ? 0.38 : 0.2;
        }
    }

    // A point and an arrow for each contact, along which its first body parts from its second.
    showContacts(contacts) {
        this.layers.contacts.clear();
        const size = 0.16 * this.radius;
        for (const { point_second: from, normal } of contacts) {
            const arrow = new THREE.ArrowHelper(
                new THREE.Vector3(...normal), new THREE.Vector3(...from), size, COLOURS.contact, 0.3 * size, 0.16 * size);
            const ball = new THREE.Mesh(new THREE.SphereGeometry(0.09 * size, 12, 8), material(COLOURS.contact, 1));
            ball.position.set(...from);
            for (const part of [arrow.line, arrow.cone, ball]) {
                // After what is translucent, and through everything: contacts are mostly hidden between two bodies.
                Object.assign(part.material, { depthTest: false, transparent: true });
                part.renderOrder = 2;
            }
            this.layers.contacts.add(arrow, ball);
        }
    }

    // Corners of the box around what moves, and around its obstacles where they are near.
    corners(places) {
        const box = { low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
        for (const poses of places) {
            for (const { geometry, body } of this.bodies.filter(made => made && made.moves)) {
                const [positions, pose] = [geometry.attributes.position.array, poses[body.frame]];
                const step = 3 * Math.ceil(positions.length / 3000);
                for (let at = 0; at < positions.length; at += step) {
                    for (let k = 0; k < 3; k++) {
                        const x = pose[k] * positions[at] + pose[3 + k] * positions[at + 1]
                            + pose[6 + k] * positions[at + 2] + pose[9 + k];
                        box.low[k] = Math.min(box.low[k], x);
                        box.high[k] = Math.max(box.high[k], x);
                    }
                }
            }
        }
        return box.low[0] <= box.high[0] ? box : { low: [-0.5, -0.5, 0], high: [0.5, 0.5, 1] };
    }

    // Looks at what moves from the side and from behind, so that it stands before what it hits.
    frameAll(places, hitAt) {
        const { low, high } = this.corners(places);
        const centre = low.map((x, k) => (x + high[k]) / 2);
        this.radius = Math.max(1e-3, Math.hypot(...high.map((x, k) => x - low[k])) / 2);
        const toward = hitAt ? Math.atan2(hitAt[1] - centre[1], hitAt[0] - centre[0]) : 0;
        const azimuth = toward + 2.2;
        const half = this.camera.fov * Math.PI / 360;
        const narrow = Math.atan(Math.tan(half) * Math.min(1, this.camera.aspect));
        const distance = 1.02 * this.radius / Math.sin(narrow);
        const [up, out] = [Math.sin(0.42), Math.cos(0.42)];
        this.camera.position.set(
            centre[0] + distance * out * Math.cos(azimuth), centre[1] + distance * out * Math.sin(azimuth), centre[2] + distance * up);
        this.camera.near = distance / 200;
        this.camera.far = distance * 40;
        this.camera.updateProjectionMatrix();
        this.orbit.target.set(...centre);
        this.orbit.update();
        this.drawGrid(low[2]);
        this.render();
    }

    // Squares of a tenth of a metre, or of another power of ten, below what moves.
    drawGrid(height) {
        this.layers.grid.clear();
        const cell = 10 ** Math.round(Math.log10(this.radius / 6));
        const count = 2 * Math.ceil(2.2 * this.radius / cell);
        const grid = new THREE.GridHelper(cell * count, count, 0xb9c1cc, 0xd8dde4);
        grid.rotation.x = Math.PI / 2;
        grid.position.set(this.orbit.target.x, this.orbit.target.y, Math.min(0, height) - 1e-3 * this.radius);
        grid.position.x -= grid.position.x % cell;
        grid.position.y -= grid.position.y % cell;
        this.layers.grid.add(grid);
        this.cell = cell;
    }

    // Puts an obstacle away from where the scene has it, by a vector [m].
    shift(body, by) {
        const made = this.bodies[body];
        if (!made) return;
        for (const part of [made.solid, made.edges]) setPose(part, [...IDENTITY.slice(0, 9), ...by]);
        this.render();
    }

    rayOf(event) {
        const box = this.renderer.domElement.getBoundingClientRect();
        const place = new THREE.Vector2(
            2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
        const ray = new THREE.Raycaster();
        ray.setFromCamera(place, this.camera);
        return ray;
    }

    // The obstacle under the pointer, where no link is before it.
    obstacleAt(event) {
        if (!this.layers.obstacles.visible) return null;
        const meshes = this.bodies.filter(made => made && made.solid).map(made => made.solid);
        const [hit] = this.rayOf(event).intersectObjects(meshes, false);
        if (!hit || this.bodies[hit.object.userData.body].moves) return null;
        return { body: hit.object.userData.body, point: hit.point.toArray() };
    }

    // Where the pointer is in the level plane through a point, or in the upright one that faces the camera.
    pointInPlane(event, point, upright) {
        const normal = upright ? this.camera.getWorldDirection(new THREE.Vector3()).setZ(0).normalize() : new THREE.Vector3(0, 0, 1);
        const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, new THREE.Vector3(...point));
        const found = this.rayOf(event).ray.intersectPlane(plane, new THREE.Vector3());
        return found ? found.toArray() : null;
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
        this.due = true;
        requestAnimationFrame(() => this.draw());
    }

    draw() {
        this.due = false;
        this.renderer.render(this.world, this.camera);
    }
}
