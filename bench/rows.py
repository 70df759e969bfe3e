#!/usr/bin/env python3
"""Many rows on many workers, for docs/how-to/rows.md: grasps of the built-in hand are released from a ball, from files to files.

    python3 bench/rows.py [--rows 1000000] [--block 16384] [CASE...]        cases: one, two, processes, dask, ray; all by default

Needs the installed package with its extras parquet and ray; `dask` needs dask[distributed]. `one` and `two` are processes of this
machine, `processes` is a ProcessPoolExecutor of two. `ray` has two local nodes of a core each, one of which is killed after a third of
the blocks, and begins a second run after the first. Each case is a program of its own, so that its memory is its own. A row may not be
lost, be there twice, or differ from that of `one`. On a busy computer processor time says more than the clock. Linux alone: memory is read from /proc.
"""
import argparse
import concurrent.futures
import hashlib
import json
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np

import extricate
from extricate import rows

CASES = ("one", "two", "processes", "dask", "ray")


def release():
    return rows.Release(extricate.Scene.builtin("hand"), object=extricate.Sphere(0.03, [0, 0, 0.08]))


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


def contents(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("part-*"))}


def run_case(case, source, output, block):
    """Runs one case; returns what it took. Called in a program of its own."""
    given = {"block": block}
    start = time.perf_counter()
    if case in ("one", "two"):
        done = rows.run(release(), source, output, workers=1 if case == "one" else 2, **given)
    elif case == "processes":
        with concurrent.futures.ProcessPoolExecutor(2) as executor:
            done = rows.run(release(), source, output, on=executor, **given)
    elif case == "dask":
        from distributed import Client

        with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
            done = rows.run(release(), source, output, on=client.get_executor(), workers=4, **given)
    else:
        done, start = on_ray(source, output, block)
    seconds = time.perf_counter() - start
    # The driver's own: workers are other processes. `ru_maxrss` would count what the program had that started this one.
    status = pathlib.Path("/proc/self/status").read_text()
    memory = int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024
    start = time.perf_counter()
    again = rows.run(release(), source, output, block=block)
    return {
        "case": case, "rows": done.rows, "new": done.new, "spoiled": done.spoiled, "seconds": seconds, "driver_mb": memory,
        "driver_cpu": processor_seconds(resource.RUSAGE_SELF), "workers_cpu": processor_seconds(resource.RUSAGE_CHILDREN),
        "second_new": again.new, "second_seconds": time.perf_counter() - start,
    }


def processor_seconds(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def on_ray(source, output, block):
    import ray
    from ray.cluster_utils import Cluster

    node = {"num_cpus": 1, "object_store_memory": 150 * 2**20}
    cluster = Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False})
    lost = [cluster.add_node(**node)]
    ray.init(address=cluster.address, log_to_driver=False)
    start = time.perf_counter()

    def lose(state):
        if lost and state.fraction > 1 / 3:
            print(f"    a node is killed after {state.done:,} rows", flush=True)
            cluster.remove_node(lost.pop(), allow_graceful=False)

    try:
        return rows.run(release(), source, output, on="ray", block=block, progress=lose), start
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
    parser.add_argument("--keys", type=int, default=100_000)
    parser.add_argument("--one-case", nargs=3, metavar=("CASE", "SOURCE", "OUTPUT"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one_case:
        case, source, output = given.one_case
        print(json.dumps(run_case(case, source, output, given.block)))
        return
    if given.keys:
        seconds, busy, kept = keys(given.keys)
        print(f"{given.keys:,} keys: {1e3 * seconds:.3f} ms each, {1e3 * busy:.3f} ms of processor time; {kept / 2**20:.0f} MB", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder) / "grasps.parquet"
        make(source, given.rows, given.block)
        first = None
        for case in given.cases or CASES:
            output = pathlib.Path(folder) / f"{case}.parquet"
            command = [sys.executable, __file__, "--one-case", case, str(source), str(output), "--block", str(given.block)]
            said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
            print("".join(line + "\n" for line in said.splitlines() if line.startswith("    a node")), end="")
            took = json.loads(said[said.rindex("{") :])
            found = contents(output)
            first = first or found
            assert took["rows"] == took["new"] == given.rows and took["second_new"] == 0, took
            assert took["spoiled"] == given.rows // 1000, took
            assert found == first, "the bytes differ"
            numbers = rows.read(output)["row"] if given.rows <= 2_000_000 else np.arange(given.rows)
            assert (numbers == np.arange(given.rows)).all(), "a row is lost or there twice"
            print(
                f"{case}: {took['seconds']:.1f} s, {given.rows / took['seconds']:,.0f} rows/s; driver at most {took['driver_mb']:.0f} MB; "
                f"processor time {took['driver_cpu']:.1f} s of the driver, {took['workers_cpu']:.1f} s of workers that it started; second run {took['second_seconds']:.2f} s, {took['spoiled']:,} spoiled rows",
                flush=True,
            )


if __name__ == "__main__":
    main()
