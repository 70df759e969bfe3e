"""Millions of rows of one scene: grasps, resets, labels, clips.

    release = extricate.rows.Release("hand.toml", objects="meshes")
    release({"q": Q, "object": names})                         # a dictionary of arrays in, one out
    extricate.rows.run(release, "grasps.parquet", "released.parquet", progress=True)

`Query`, `Distance`, `Release`, `Repair` and `Check` are callable classes: what `map_batches` of Ray Data, `map` of an executor, Dask and joblib take.
`run` goes from files to files. Read in this order: `_mappers` (what is done with rows), `_columns` and `_hands` (what rows are), `_run`
(blocks), `_files` (formats).
"""

from .._pool import Progress
from ._hands import Hands
from ._mappers import Check, Distance, Query, Release, Repair
from ._run import Done, batches, read, run

__all__ = ["Check", "Distance", "Done", "Hands", "Progress", "Query", "Release", "Repair", "batches", "read", "run"]
