"""Releases hands from files to files: on this machine, in a ProcessPoolExecutor, on Dask, on a cluster of Ray, or with Ray Data."""

import argparse
import concurrent.futures
import contextlib
import pathlib

import numpy as np

import extricate


@contextlib.contextmanager
def place(name):
    """Gives what `rows.run` takes as `on`."""
    if name == "processes":
        with concurrent.futures.ProcessPoolExecutor() as executor:
            yield executor
    elif name == "dask":
        from distributed import Client

        with Client() as client:                    # on a cluster: Client("scheduler:8786")
            yield client.get_executor()
    else:
        yield "ray" if name == "ray" else None      # RAY_ADDRESS names a cluster; without it, Ray begins on this machine


def with_ray_data(release, source, output):
    """Does the same by Ray Data, which cuts the rows into blocks of its own."""
    import ray

    ray.data.read_parquet(str(source)).map_batches(release, batch_size=4096).write_parquet(str(output))


def main(folder=".", on="here", count=2000):
    hand = extricate.Scene.builtin("hand")
    release = extricate.rows.Release(hand, object=extricate.Sphere(0.03, [0, 0, 0.08]))
    folder = pathlib.Path(folder)
    source, output = folder / "grasps.npz", folder / f"released-{on}.npz"
    if on == "ray-data":
        import pyarrow.parquet

        source, output = folder / "grasps.parquet", folder / "released-ray-data.parquet"
        pyarrow.parquet.write_table(pyarrow.table({"q": hand.sample(count, seed=1).tolist(), "row": np.arange(count)}), source)
        with_ray_data(release, source, output)
    else:
        if not source.exists():                     # a file that changed would be another input
            np.savez(source, q=hand.sample(count, seed=1), row=np.arange(count))
        with place(on) as where:
            print(extricate.rows.run(release, source, output, block=500, on=where))
    return extricate.rows.read(output)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", default=".")
    parser.add_argument("--on", default="here", choices=["here", "processes", "dask", "ray", "ray-data"])
    given = parser.parse_args()
    released = main(given.folder, given.on)
    print(f"{len(released['config'])} hands, {np.count_nonzero(released['error'] != '')} spoiled")
