"""Sliders in a browser with viser: every move of a joint queries, and the nearest exit is drawn beside the query."""

import sys
import time

import numpy as np
import viser
import viser.transforms

import extricate

HIT, FREE, OBSTACLE = (213, 94, 0), (47, 134, 193), (200, 191, 166)


def add_bodies(server, scene, name, color, opacity=None):
    """Draws every body of a scene under `name`; returns the handles in the order of `Scene.bodies`."""
    def add(body):
        vertices, triangles = scene.mesh(body)
        return server.scene.add_mesh_simple(f"/{name}/{body}", vertices, triangles, color=color, opacity=opacity, flat_shading=True)
    return [add(body) for body in scene.bodies]


def place(scene, handles, q):
    """Moves the handles to where the bodies are at `q`."""
    for handle, pose in zip(handles, scene.poses(q)):
        handle.position = pose[:3, 3]
        handle.wxyz = viser.transforms.SO3.from_matrix(pose[:3, :3]).wxyz


def show(source, scene, q, port=8080):
    """Serves sliders, to this computer alone; `source` is the scene or a model. Returns the server and what a move calls."""
    server = viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
    query, witness = add_bodies(server, scene, "query", HIT, 0.3), add_bodies(server, scene, "witness", FREE)
    sliders = [
        server.gui.add_slider(joint.name, float(low), float(high), 1e-3, float(x))
        for joint, low, high, x in zip(scene.joints, scene.lower, scene.upper, q)
    ]
    text = server.gui.add_markdown("")

    def update(_=None):
        answer = source.query(np.array([slider.value for slider in sliders]))
        place(scene, query, [slider.value for slider in sliders])
        place(scene, witness, answer.witness)
        text.content = f"```\n{answer}\n```"
        return answer

    for slider in sliders:
        slider.on_update(update)
    return server, update


def main(seconds=None):
    scene = extricate.Scene.builtin("shelf-arm")
    server, update = show(scene, scene, scene.sample(1, seed=1, colliding=True)[0])
    answer = update()
    print(f"open http://127.0.0.1:{server.get_port()}")
    time.sleep(float(seconds) if seconds is not None else 1e9)
    server.stop()
    return answer


if __name__ == "__main__":
    main(*sys.argv[1:])
