"""Files of rows: Parquet, NumPy's .npy and .npz, and JSON lines. They are read block by block, and written whole."""

from __future__ import annotations

import dataclasses
import importlib
import json
import math
import os
import pathlib
import struct
import zipfile
from typing import IO, Any, Dict, Iterator, List, Sequence, Tuple, Union

import numpy as np

from .._folder import whole
from ._columns import Array, objects

Path = Union[str, "os.PathLike[str]"]
Columns = Dict[str, Array]

# What a folder of a run was made from. Names that begin so are no data for pyarrow, Ray and Spark.
RECORD = "_run.json"
INPUTS = (".parquet", ".npy", ".npz", ".jsonl")
OUTPUTS = (".parquet", ".npz", ".jsonl")


@dataclasses.dataclass(frozen=True)
class Block:
    """Rows `start` to `stop` of a file; `mark` is where they begin in a file of lines [bytes]."""

    path: pathlib.Path
    start: int
    stop: int
    mark: int = 0


def files(given: Union[Path, Sequence[Path]]) -> List[pathlib.Path]:
    """Returns the files of a path, of a folder, or of several of them, those of a folder by name.

    Raises ValueError if there is none, or one of another format, and for the output of a run that is not done; FileNotFoundError if
    one is missing.
    """
    paths = [given] if isinstance(given, (str, os.PathLike)) else list(given)
    found: List[pathlib.Path] = []
    for path in map(pathlib.Path, paths):
        if (path / RECORD).exists():
            _check_done(path)
        inside = sorted(path.iterdir()) if path.is_dir() else [path]
        kept = [file for file in inside if not path.is_dir() or (file.suffix in INPUTS and file.name[0] not in "._")]
        if not kept:
            raise ValueError(f"{path}: got a folder without files of rows, expected {', '.join(INPUTS)}")
        found += kept
    for file in found:
        if file.suffix not in INPUTS:
            raise ValueError(f"{file}: got a name that ends with {file.suffix!r}, expected {', '.join(INPUTS)}")
        if not file.is_file():
            raise FileNotFoundError(f"{file}: no such file")
    return [file.absolute() for file in found]


def _check_done(folder: pathlib.Path) -> None:
    """Raises ValueError if the run that writes to a folder is not done."""
    try:
        parts = int(json.loads((folder / RECORD).read_text(encoding="utf-8"))["parts"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{folder / RECORD}: {error!r}, expected what rows.run wrote") from None
    there = len(list(folder.glob("part-*")))
    if there < parts:
        raise ValueError(f"{folder}: got {there} of {parts} blocks, expected the output of a run that is done; its files can be given one by one")


def blocks(path: pathlib.Path, rows: int) -> List[Block]:
    """Returns the blocks of a file, each of so many rows but the last. Raises ValueError if it cannot be read."""
    marks: List[int] = []
    total = 0
    if path.suffix == ".jsonl":
        with open(path, "rb") as file:
            at = 0
            for line in file:
                if line.strip():
                    if total % rows == 0:
                        marks.append(at)
                    total += 1
                at += len(line)
    elif path.suffix == ".parquet":
        total = _parquet(path).metadata.num_rows
    else:
        lengths = {name: len(array) for name, array in _arrays(path).items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"{path}: got arrays of {lengths} rows, expected as many in each")
        total = next(iter(lengths.values()), 0)
    starts = range(0, total, rows)
    return [Block(path, start, min(start + rows, total), mark) for start, mark in zip(starts, marks or [0] * len(starts))]


def read(block: Block) -> Columns:
    """Returns the columns of a block. A line that is no JSON object gets a reason in the column `error`."""
    if block.path.suffix == ".jsonl":
        with open(block.path, "rb") as file:
            file.seek(block.mark)
            return _of_lines(_lines(file, block.stop - block.start))
    if block.path.suffix == ".parquet":
        return _of_parquet(block)
    return {name: np.array(array[block.start : block.stop]) for name, array in _arrays(block.path).items()}


def write(path: pathlib.Path, columns: Columns) -> None:
    """Writes columns to a file, which is there only once all of it is."""
    with whole(path) as file:
        if path.suffix == ".jsonl":
            _to_lines(file, columns)
        elif path.suffix == ".parquet":
            pyarrow = _pyarrow()
            table = pyarrow.table({name: _to_arrow(pyarrow, values) for name, values in columns.items()})
            importlib.import_module("pyarrow.parquet").write_table(table, file)
        else:
            bad = [name for name, values in columns.items() if values.dtype == object]
            if bad:
                raise ValueError(f"{path.suffix}: got the column {bad[0]!r} with rows of different shapes, expected .parquet or .jsonl")
            # As np.savez does, but for columns of any name.
            with zipfile.ZipFile(file, "w") as archive:
                for name, values in columns.items():
                    with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                        np.lib.format.write_array(member, np.asarray(values), allow_pickle=False)


# JSON lines


def _lines(file: IO[bytes], rows: int) -> Iterator[bytes]:
    for line in file:
        if rows == 0:
            return
        if line.strip():
            rows -= 1
            yield line


def _of_lines(lines: Iterator[bytes]) -> Columns:
    rows: List[Dict[str, Any]] = []
    for line in lines:
        try:
            row = json.loads(line)
            if isinstance(row, list):
                row = {"q": row}
            if not isinstance(row, dict):
                raise ValueError(f"got {type(row).__name__}")
            rows.append(dict(_flat("", row)))
        except (ValueError, RecursionError) as error:
            rows.append({"error": f"line: {error}, expected a JSON object"})
    names = list(dict.fromkeys(name for row in rows for name in row))
    found = {name: _column([row.get(name) for row in rows]) for name in names}
    if "error" in found:
        found["error"] = np.array([said or "" for said in found["error"]], dtype=np.str_)
    return found


def _flat(prefix: str, row: Dict[str, Any]) -> Iterator[Tuple[str, Any]]:
    """Gives the values of an object; those of an object within it have the name `outer.inner`."""
    for name, value in row.items():
        if isinstance(value, dict):
            yield from _flat(f"{prefix}{name}.", value)
        else:
            yield f"{prefix}{name}", value


def _column(values: List[Any]) -> Array:
    """Returns values as numbers or texts if they all are alike, else as objects."""
    try:
        found = np.array(values)
    except ValueError:
        return objects(values)
    alike = found.dtype.kind in "fiub" or (found.dtype.kind == "U" and all(isinstance(value, str) for value in values))
    return found if alike else objects(values)


def _to_lines(file: IO[bytes], columns: Columns) -> None:
    names = list(columns)
    for row in zip(*columns.values()):
        file.write(json.dumps(dict(zip(names, map(_json, row)))).encode() + b"\n")


def _json(value: Any) -> Any:
    """Converts a value for JSON; numbers that are not finite are null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_json(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# NumPy


def _arrays(path: pathlib.Path) -> Columns:
    """Returns the arrays of a file, mapped into memory if they are not compressed.

    Raises ValueError for arrays of Python objects: opening them would run code of the file.
    """
    try:
        if path.suffix == ".npz":
            with zipfile.ZipFile(path) as archive:
                found = {info.filename[: -len(".npy")]: _member(path, archive, info) for info in archive.infolist()}
        else:
            array = np.load(path, mmap_mode="r", allow_pickle=False)
            found = {name: array[name] for name in array.dtype.names} if array.dtype.names else {"q": array}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: {error}, expected arrays of numbers or texts") from None
    return found


def _member(path: pathlib.Path, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Array:
    with archive.open(info) as member:
        if info.compress_type != zipfile.ZIP_STORED:
            packed: Array = np.lib.format.read_array(member, allow_pickle=False)
            return packed
        version = np.lib.format.read_magic(member)
        read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, is_fortran, dtype = read_header(member)
        header = member.tell()
    if dtype.hasobject:
        raise ValueError("got an array of Python objects")
    if 0 in shape or dtype.itemsize == 0:
        return np.zeros(shape, dtype)
    with open(path, "rb") as file:
        file.seek(info.header_offset + 26)
        name_length, extra_length = struct.unpack("<HH", file.read(4))
    offset = info.header_offset + 30 + name_length + extra_length + header
    return np.memmap(path, dtype, "r", offset, shape, "F" if is_fortran else "C")


# Parquet


def _pyarrow() -> Any:
    try:
        importlib.import_module("pyarrow.parquet")
        return importlib.import_module("pyarrow")
    except ImportError:
        raise ImportError('Parquet needs the package pyarrow: pip install "extricate[parquet]"') from None


def _parquet(path: pathlib.Path) -> Any:
    pyarrow = _pyarrow()
    try:
        return pyarrow.parquet.ParquetFile(path)
    except pyarrow.ArrowInvalid as error:
        raise ValueError(f"{path}: {error}, expected Parquet") from None


def _of_parquet(block: Block) -> Columns:
    pyarrow, file = _pyarrow(), _parquet(block.path)
    groups: List[int] = []
    first = begin = 0
    for group in range(file.num_row_groups):
        rows = file.metadata.row_group(group).num_rows
        if first < block.stop and first + rows > block.start:
            begin = begin if groups else first
            groups.append(group)
        first += rows
    parts, at = [], begin
    # Batches keep a large group out of memory.
    for batch in file.iter_batches(row_groups=groups):
        start, stop = max(block.start - at, 0), min(block.stop - at, len(batch))
        if start < stop:
            parts.append(batch.slice(start, stop - start))
        at += len(batch)
        if at >= block.stop:
            break
    table = pyarrow.Table.from_batches(parts) if parts else file.schema_arrow.empty_table()
    while any(pyarrow.types.is_struct(kind) for kind in table.schema.types):
        table = table.flatten()
    return {name: _of_arrow(pyarrow, table[name].combine_chunks()) for name in table.column_names}


def _of_arrow(pyarrow: Any, values: Any) -> Array:
    """Converts a column. Lists of one length become an array of two dimensions or more, others an array of objects."""
    if isinstance(values, pyarrow.ChunkedArray):
        values = values.chunk(0) if values.num_chunks else pyarrow.array([], values.type)
    if isinstance(values, pyarrow.ExtensionArray):
        values = values.storage
    kinds = pyarrow.types
    if kinds.is_list(values.type) or kinds.is_large_list(values.type) or kinds.is_fixed_size_list(values.type):
        lengths = importlib.import_module("pyarrow.compute").list_value_length(values).unique().to_pylist()
        if len(values) == 0:
            lengths = [getattr(values.type, "list_size", 0)]
        if len(lengths) == 1 and lengths[0] is not None:
            inner = _of_arrow(pyarrow, values.flatten())
            return inner.reshape(len(values), lengths[0], *inner.shape[1:])
        return objects([None if row is None else _column(row) for row in values.to_pylist()])
    if kinds.is_string(values.type) or kinds.is_large_string(values.type):
        texts = values.to_pylist()
        return objects(texts) if None in texts else np.array(texts, dtype=np.str_)
    if values.null_count and (kinds.is_integer(values.type) or kinds.is_boolean(values.type)):
        return objects(values.to_pylist())
    converted: Array = values.to_numpy(zero_copy_only=False)
    return converted


def _to_arrow(pyarrow: Any, values: Array) -> Any:
    if values.ndim > 1:
        inner = _to_arrow(pyarrow, values.reshape(-1, *values.shape[2:]))
        return pyarrow.FixedSizeListArray.from_arrays(inner, values.shape[1])
    if values.dtype.kind == "U":
        return pyarrow.array(values.tolist(), pyarrow.string())
    if values.dtype == object:
        arrays = [value for value in values if isinstance(value, np.ndarray)]
        kind = None
        if len(arrays) == len(values) and arrays and all(one.dtype == np.float64 for one in arrays):
            kind = pyarrow.float64()
            for _ in range(arrays[0].ndim):
                kind = pyarrow.list_(kind)
        return pyarrow.array([value.tolist() if isinstance(value, np.ndarray) else value for value in values], kind)
    return pyarrow.array(values)
