#!/usr/bin/env python3
"""Many rows on many workers, for docs/how-to/rows.md: grasps of the built-in hand are released from a ball, from files to files.

    python3 bench/rows.py [--rows 1000000] [--block 16384] [--mapper release] [CASE...]

Cases are one, two, processes, dask and ray; all by default. `--mapper check` labels the configurations instead of releasing them.
Needs the installed package with its extras parquet and ray; `dask` needs dask[distributed]. `one` and `two` are processes of this
machine, `processes` is a ProcessPoolExecutor of two. `ray` has two local nodes of a core each, one of which is killed after a third of
the rows. Each case is a program of its own, so that its memory is its own. A row may not be lost, be there twice, or differ from that
of the first case, and a second run may do nothing.

On a busy computer the clock says little, so the share of linear is by processor time: what one worker takes for all rows, over what
two take, where the time of the program that hands out counts for both cores. Linux alone: memory is read from /proc.
"""
import argparse
import concurrent.futures
import hashlib
import importlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy as np

import extricate
from extricate import rows

CASES = ("one", "two", "processes", "dask", "ray")
MAPPERS = {
    "release": lambda hand: rows.Release(hand, object=extricate.Sphere(0.03, [0, 0, 0.08])),
    "check": rows.Check,
    "distance": rows.Distance,
}


class Measured:
    """A mapper that notes the processor time of its process in a file of `folder`."""

    def __init__(self, mapper, folder):
        self.mapper, self.folder, self.digest = mapper, folder, mapper.digest

    def __call__(self, batch):
        found = self.mapper(batch)
        (pathlib.Path(self.folder) / str(os.getpid())).write_text(str(time.process_time()))
        return found


def make(path, count, block):
    """Writes configurations of the hand, one in a thousand of them spoiled, in row groups of a block."""
    import pyarrow
    import pyarrow.parquet

    hand = extricate.Scene.builtin("hand")
    schema = pyarrow.schema([("q", pyarrow.list_(pyarrow.float64(), hand.nq)), ("row", pyarrow.int64())])
    with pyarrow.parquet.ParquetWriter(path, schema) as writer:
        for first in range(0, count, block):
            number = min(block, count - first)
            q = hand.sample(number, seed=first)
            q[(first + np.arange(number)) % 1000 == 999, 2] = np.nan
            listed = pyarrow.FixedSizeListArray.from_arrays(q.ravel(), hand.nq)
            writer.write_table(pyarrow.table([listed, np.arange(first, first + number)], schema=schema))


def digest_of(folder):
    """Hashes the names and the bytes of the files of rows."""
    found = hashlib.sha256()
    for path in sorted(folder.glob("part-*")):
        found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()[:16]


def run_case(case, mapper, source, output, block):
    """Runs one case; returns what it took. Called in a program of its own."""
    with tempfile.TemporaryDirectory() as folder:
        # Workers import the class by the name of this file, which is `__main__` here.
        measured = importlib.import_module("rows").Measured(MAPPERS[mapper](extricate.Scene.builtin("hand")), folder)
        start, busy = time.perf_counter(), time.process_time()
        if case in ("one", "two"):
            done = rows.run(measured, source, output, workers=1 if case == "one" else 2, block=block)
        elif case == "processes":
            with concurrent.futures.ProcessPoolExecutor(2) as executor:
                done = rows.run(measured, source, output, on=executor, block=block)
        elif case == "dask":
            from distributed import Client

            with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
                done = rows.run(measured, source, output, on=client.get_executor(), workers=4, block=block)
        else:
            done, start, busy = on_ray(measured, source, output, block)
        seconds = time.perf_counter() - start
        workers = sum(float(file.read_text()) for file in pathlib.Path(folder).iterdir())
        # The driver's own: workers are other processes. `ru_maxrss` would count what the program had that started this one.
        status = pathlib.Path("/proc/self/status").read_text()
        memory = int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024
        driver = time.process_time() - busy
        start = time.perf_counter()
        again = rows.run(measured, source, output, block=block)
    return {
        "rows": done.rows, "new": done.new, "spoiled": done.spoiled, "seconds": seconds, "driver_mb": memory, "driver_cpu": driver,
        "workers_cpu": workers, "second_new": again.new, "second_seconds": time.perf_counter() - start,
    }


def on_ray(mapper, source, output, block):
    import ray
    from ray.cluster_utils import Cluster

    node = {"num_cpus": 1, "object_store_memory": 150 * 2**20}
    cluster = Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False})
    lost = [cluster.add_node(**node)]
    ray.init(address=cluster.address, log_to_driver=False)
    start, busy = time.perf_counter(), time.process_time()

    def lose(state):
        if lost and state.fraction > 1 / 3:
            print(f"    a node is killed after {state.done:,} rows", flush=True)
            cluster.remove_node(lost.pop(), allow_graceful=False)

    try:
        return rows.run(mapper, source, output, on="ray", block=block, progress=lose), start, busy
    finally:
        ray.shutdown()
        cluster.shutdown()


def keys(count):
    """Returns the seconds and the processor seconds that the bookkeeping of a fleet takes for each key with a model, and the bytes."""
    from extricate.fleet._manifest import Manifest

    statistics = {f"figure {k}": k / 7 for k in range(25)}
    with tempfile.TemporaryDirectory() as folder:
        manifest = Manifest(pathlib.Path(folder))
        with manifest.held():
            start, busy = time.perf_counter(), time.process_time()
            for at in range(count):
                content = f"{at:040x}"
                manifest.note(content, 0, statistics)
                manifest.name(f"key {at}", content)
            taken = (time.perf_counter() - start) / count, (time.process_time() - busy) / count
        return (*taken, (pathlib.Path(folder) / "manifest.sqlite").stat().st_size)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", choices=[*CASES, []], metavar="CASE")
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--block", type=int, default=16_384)
    parser.add_argument("--mapper", choices=MAPPERS, default="release")
    parser.add_argument("--keys", type=int, default=100_000)
    parser.add_argument("--one-case", nargs=3, metavar=("CASE", "SOURCE", "OUTPUT"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one_case:
        case, source, output = given.one_case
        print(json.dumps(run_case(case, given.mapper, source, output, given.block)))
        return
    if given.keys:
        seconds, busy, kept = keys(given.keys)
        print(f"{given.keys:,} keys: {1e3 * seconds:.3f} ms each, {1e3 * busy:.3f} ms of processor time; {kept / 2**20:.0f} MB", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder) / "grasps.parquet"
        make(source, given.rows, given.block)
        first = single = None
        for case in given.cases or CASES:
            output = pathlib.Path(folder) / f"{case}.parquet"
            command = [sys.executable, __file__, "--one-case", case, source, output, "--block", str(given.block), "--mapper", given.mapper]
            environment = {**os.environ, "PYTHONPATH": str(pathlib.Path(__file__).parent.resolve())}
            said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, env=environment).stdout
            print("".join(line + "\n" for line in said.splitlines() if line.startswith("    a node")), end="")
            took = json.loads(said[said.rindex("{") :])
            found = digest_of(output)
            first = first or found
            assert took["rows"] == took["new"] == given.rows and took["second_new"] == 0, took
            assert took["spoiled"] == given.rows // 1000, took
            assert found == first, "the bytes differ"
            numbers = rows.read(output)["row"]
            assert (numbers == np.arange(given.rows)).all(), "a row is lost or there twice"
            driver, workers = took["driver_cpu"], took["workers_cpu"]
            print(
                f"{case}: {given.rows:,} rows in {took['seconds']:.1f} s; driver at most {took['driver_mb']:.0f} MB; processor time "
                f"{driver:.1f} s of the driver, {workers:.1f} s of workers; {took['spoiled']:,} spoiled rows; bytes {found}; second run {took['second_seconds']:.2f} s",
                end="",
            )
            if case == "one":
                single = driver + workers
            elif single:
                print(f"; {single / (2 * driver + workers):.2f} of linear over two cores", end="")
            print(flush=True)


if __name__ == "__main__":
    main()
