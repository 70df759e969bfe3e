"""Runs over files of rows: block by block, on many processors or machines, and again where they ended."""

from __future__ import annotations

import dataclasses
import functools
import json
import pathlib
import pickle
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from .. import _pool
from .._folder import digest, held, whole
from .._pool import Job, On, Progress, Tell
from .._tensors import to_numpy
from . import _files
from ._columns import objects
from ._files import OUTPUTS, RECORD, Block, Columns, Path

VERSION = 1


@dataclasses.dataclass(frozen=True)
class Done:
    """What a run did.

    rows: all rows of the input; each is in one file of the output.
    new: those that this run worked on.
    spoiled: those of `new` that have an `error`.
    """

    rows: int
    new: int
    spoiled: int


def run(
    mapper: Callable[[Columns], Mapping[str, Any]],
    input: Union[Path, Sequence[Path]],
    output: Path,
    *,
    on: On = None,
    workers: int = 0,
    block: int = 65_536,
    progress: Optional[Tell] = None,
) -> Done:
    """Maps files of rows to files of rows. A run that was ended goes on where it was, and one that is done does nothing.

    mapper: such as `rows.Release(..)`, or any function of a dictionary of arrays that workers can import.
    input: a file, a folder of files, or several of these: .parquet, .npz, .npy (the column `q`) or .jsonl.
    output: a folder whose name ends with the format of its files: .parquet, .npz or .jsonl; made if it is missing. Files are
        named by number, in the order of the input, and have the rows of a block each.
    on: None for processes of this machine, "ray" for the cluster that Ray is connected to, or an `Executor` of concurrent.futures,
        such as `ProcessPoolExecutor()` or `get_executor()` of a client of Dask. Workers read the input and write the output
        themselves, so every machine has to see both folders.
    workers: how many blocks at once; 0 for one per core of the machine, or for what the cluster has, however it grows.
    block: rows of a block.
    progress: True for a bar, or a function that is called with a `Progress` after each block.

    A spoiled row is a row with a reason in the column `error`. The bytes of the output depend on none of `on` and `workers`. A
    worker that dies loses its block alone, which is begun again up to three times.

    Raises ValueError for arguments that make no sense, and if the folder was made by another mapper, of another input or with
    another `block`; OSError where another run writes to it; RuntimeError after all other blocks are done, if some failed: a further
    run begins these again.
    """
    if isinstance(block, bool) or not isinstance(block, int) or block < 1:
        raise ValueError(f"block: got {block!r}, expected a whole number of at least 1")
    folder = pathlib.Path(output).absolute()
    if folder.suffix not in OUTPUTS:
        raise ValueError(f"output: got {str(output)!r}, expected a name that ends with {', '.join(OUTPUTS)}")
    pool = _pool.Pool(on, workers, getattr(mapper, "threads", 1))
    try:
        sources = _files.files(input)
        if any(folder in source.absolute().parents for source in sources):
            raise ValueError(f"output: got {str(output)!r}, expected another folder than the input")
        folder.mkdir(parents=True, exist_ok=True)
        with held(folder, "rows.run"), _pool.telling(progress) as tell:
            parts = [part for source in sources for part in _files.blocks(source, block)]
            made_from = {"mapper": _digest(mapper), "block": block, "input": [_state(source) for source in sources]}
            _keep_record(folder, {"version": VERSION, **made_from, "parts": len(parts)})
            return _run(pool, pickle.dumps(mapper), parts, folder, tell)
    finally:
        pool.close()


def _run(pool: _pool.Pool, mapper: bytes, parts: List[Block], folder: pathlib.Path, tell: Callable[[Progress], Any]) -> Done:
    there = {path.name for path in folder.iterdir()}
    total = sum(part.stop - part.start for part in parts)
    missing = [at for at in range(len(parts)) if _name(at, folder) not in there]
    done = total - sum(parts[at].stop - parts[at].start for at in missing)
    new = spoiled = 0
    failed: Dict[int, str] = {}
    shared = pool.share(mapper)
    jobs = (Job(at, _work, (shared, parts[at], folder / _name(at, folder))) for at in missing)
    tell(Progress(done, 0, total, "rows"))
    for at, result, error in pool.outcomes(jobs):
        if error is None:
            new, spoiled = new + result[0], spoiled + result[1]
            tell(Progress(done + new, spoiled, total, "rows"))
        else:
            failed[at] = error
    if failed:
        first = min(failed)
        raise RuntimeError(
            f"{folder}: {len(failed)} of {len(parts)} blocks failed, first rows {parts[first].start} to {parts[first].stop} of "
            f"{parts[first].path} ({failed[first]}); run again for these"
        )
    return Done(total, new, spoiled)


def _name(number: int, folder: pathlib.Path) -> str:
    return f"part-{number:06d}{folder.suffix}"


def _work(mapper: bytes, block: Block, target: pathlib.Path) -> Tuple[int, int]:
    """Maps a block; returns how many rows it has, and how many of these are spoiled."""
    found = _mapper(mapper)(_files.read(block))
    columns = {name: to_numpy(name, values) for name, values in found.items()}
    rows = block.stop - block.start
    for name, values in columns.items():
        if len(values) != rows:
            raise ValueError(f"{name}: got {len(values)} rows from the mapper, expected {rows}")
    _files.write(target, columns)
    return rows, int(np.count_nonzero(columns["error"] != "")) if "error" in columns else 0


# A process makes a mapper once.
_mapper = functools.lru_cache(maxsize=2)(pickle.loads)


def _digest(mapper: Callable[..., Any]) -> str:
    own = getattr(mapper, "digest", None)
    return str(own()) if own else digest(None, pickle.dumps(mapper))


def _state(path: pathlib.Path) -> List[Any]:
    """Returns what tells a file from another one, or from itself after a change."""
    state = path.stat()
    return [path.name, state.st_size, state.st_mtime_ns]


def _keep_record(folder: pathlib.Path, record: Dict[str, Any]) -> None:
    """Notes what the folder is made from. Raises ValueError if that was something else; input may have become longer."""
    file = folder / RECORD
    if not file.exists() and any(path.name.startswith("part-") for path in folder.iterdir()):
        raise ValueError(f"{folder}: got files of another origin, expected a new folder")
    if file.exists():
        try:
            known = json.loads(file.read_text(encoding="utf-8"))
            same_input = known["input"] == record["input"][: len(known["input"])]
            changed = [name for name in ("version", "mapper", "block") if known[name] != record[name]] + ["input"] * (not same_input)
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{file}: {error!r}, expected what rows.run wrote") from None
        if changed:
            raise ValueError(f"{folder}: got output of another {changed[0]}, expected the same one, or a folder of another name")
    with whole(file) as out:
        out.write(json.dumps(record).encode())


def read(path: Union[Path, Sequence[Path]]) -> Columns:
    """Returns all rows of files as one dictionary of arrays.

    path: as the input of `run`, such as its output.

    Raises ValueError for files that cannot be read, for columns that some files lack, and for the output of a run that is not done.
    """
    found: List[Columns] = []
    for file in _files.files(path):
        found += [_files.read(block) for block in _files.blocks(file, 1 << 62)]
    for columns in found[1:]:
        if list(columns) != list(found[0]):
            raise ValueError(f"{path}: got files with the columns {list(found[0])} and {list(columns)}, expected the same in each")
    return {name: _joined([columns[name] for columns in found]) for name in found[0]} if found else {}


def _joined(arrays: List[Any]) -> Any:
    kinds = {array.dtype.kind for array in arrays}
    if len(kinds) == 1 and all(array.dtype != object and array.shape[1:] == arrays[0].shape[1:] for array in arrays):
        return np.concatenate(arrays)
    return objects([row for array in arrays for row in array])


def batches(path: Union[Path, Sequence[Path]], block: int) -> Iterator[Columns]:
    """Yields the rows of files as dictionaries of arrays, for `map` of executors and joblib.

    path, block: as in `run`.
    """
    for file in _files.files(path):
        for part in _files.blocks(file, block):
            yield _files.read(part)
