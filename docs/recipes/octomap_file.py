"""Asks in the world of an OctoMap file: its occupied leaves become one obstacle of voxels."""

import pathlib
import tempfile

import numpy as np
import pyoctomap

import extricate


def voxels(path, name="map"):
    """The occupied leaves of an OctoMap file (.bt or .ot); large leaves are cut to the finest cells."""
    tree = pyoctomap.OcTree(0.1)
    if not tree.readBinary(str(path)):
        raise ValueError(f"{path}: expected an OctoMap file")
    size = tree.getResolution()
    cells = []
    for leaf in tree.begin_leafs():
        if tree.isNodeOccupied(leaf):
            count = round(leaf.getSize() / size)
            first = np.round(np.array(leaf.getCoordinate()) / size - count / 2).astype(int)
            steps = np.indices((count, count, count)).reshape(3, -1).T
            cells.append(first + steps)
    return extricate.Voxels(np.concatenate(cells), size, name=name)


def main():
    # A wall before the arm, as a map would hold it.
    tree = pyoctomap.OcTree(0.05)
    for y in np.arange(-0.6, 0.6, 0.05):
        for z in np.arange(0.2, 1.2, 0.05):
            tree.updateNode([0.45, y + 0.025, z + 0.025], True)
    path = pathlib.Path(tempfile.mkdtemp()) / "wall.bt"
    tree.writeBinary(str(path))

    scene = extricate.Scene.builtin("shelf-arm")
    world = scene.with_obstacles([voxels(path)])
    q = next(q for q in scene.sample(2000, seed=1, colliding=False) if not world.check(q))
    answer = world.query(q)
    print(f"{len(world.bodies)} bodies, one of them the map; {answer.depth:.4f} rad out of {answer.colliding}")
    return world, q, answer


if __name__ == "__main__":
    main()
