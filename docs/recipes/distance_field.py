"""A learned distance field: signed distances as a data set in a file, a small network that is fitted to it, and its error on configurations that it has not seen."""

import pathlib
import tempfile

import numpy as np
from sklearn.neural_network import MLPRegressor

import extricate


def write_data(scene, count, path, seed=1):
    """Writes q (n, nq), distance (n,), bound (n,), gradient (n, nv) of random configurations. Rows without a distance are left out."""
    q = scene.sample(count, seed=seed)
    rows = scene.signed_distance(q)
    known = np.isfinite(rows["distance"])
    np.savez(path, q=q[known], **{name: rows[name][known] for name in ("distance", "bound", "gradient")})


def features(q):
    """Sines and cosines (n, 4 nq) of the joints' angles and of the directions of the planar links. They do not jump where an angle wraps."""
    angles = np.hstack([q, np.cumsum(q, axis=1)])
    return np.hstack([np.sin(angles), np.cos(angles)])


def projected(scene, q, distance, gradient):
    """Moves q by a distance against its gradient, to where contact should be."""
    step = distance[:, None] * gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
    wrapped = (q - step + np.pi) % (2 * np.pi) - np.pi
    return np.clip(wrapped, scene.lower, scene.upper)


def on_the_way(q, distance, gradient):
    """Adds to each row two on the way to its witness, which is their nearest too: at half the distance, and in contact."""
    shares = np.array([1, 0.5, 0])[:, None]
    return (q - ((1 - shares) * distance)[..., None] * gradient).reshape(-1, q.shape[1]), (shares * distance).ravel()


def main(folder, count=4000, epochs=40):
    scene = extricate.Scene.builtin("planar-arm")
    path = pathlib.Path(folder) / "distances.npz"
    write_data(scene, count, path)
    data = np.load(path)
    q, distance, gradient, held = data["q"], data["distance"], data["gradient"], len(data["q"]) // 10
    more, wanted = on_the_way(q[held:], distance[held:], gradient[held:])
    unit = wanted.std()
    network = MLPRegressor(hidden_layer_sizes=(128, 128), learning_rate_init=2e-3, max_iter=epochs, tol=0, n_iter_no_change=epochs, random_state=0)
    network.fit(features(more), wanted / unit)

    def learned(q):
        return unit * network.predict(features(q))

    q, distance, gradient = q[:held], distance[:held], gradient[:held]
    slopes = np.array([learned(q + step) - learned(q - step) for step in 1e-3 * np.eye(scene.nq)]).T
    error = np.abs(learned(q) - distance)
    # How far [m] from contact a step of the learned distance ends, beside a step of the distance itself.
    steps = (learned(q), slopes), (distance, gradient)
    off, own = (np.abs(scene.distances(projected(scene, q, *step)) - scene.clearance) for step in steps)
    wrong = (learned(q) > 0) != (distance > 0)
    print(f"{held} configurations held out: {(distance > 0).mean():.0%} free, |distance| {np.abs(distance).mean():.3f} rad in the mean")
    print(f"error: mean {error.mean():.4f} rad, 95 % below {np.quantile(error, 0.95):.4f} rad; wrong sign {wrong.mean():.1%}")
    print(f"a step of the learned distance ends {100 * off.mean():.2f} cm from contact in the mean, one of the distance itself {100 * own.mean():.4f} cm")
    return data, error, off, own


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        main(folder)
