"""What runs keep in a folder: files that are written whole, a lock, and hashes of what results depend on."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import pathlib
import sqlite3
import uuid
from typing import IO, Any, Iterator

from ._extricate import __version__


def digest(settings: Any, *contents: bytes) -> str:
    """Hashes settings, contents and the version of the library."""
    found = hashlib.blake2b(digest_size=20)
    for part in (json.dumps([__version__, settings], default=_plain, sort_keys=True).encode(), *contents):
        found.update(len(part).to_bytes(8, "little") + part)
    return found.hexdigest()


def _plain(value: Any) -> Any:
    """Converts arrays and numbers of NumPy to what JSON has; other values to their text."""
    return value.tolist() if hasattr(value, "tolist") else repr(value)


@contextlib.contextmanager
def whole(path: pathlib.Path) -> Iterator[IO[bytes]]:
    """Opens a file that takes the place of `path` once all is written; an error leaves `path` as it is."""
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex}")  # `_clear` knows the form.
    try:
        with open(temporary, "xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def held(folder: pathlib.Path, call: str) -> Iterator[None]:
    """Locks a folder for one run of `call`. The system unlocks it when the program ends, even by a crash. What writers that were
    killed left unfinished is removed, of this run and of those before.

    Raises BlockingIOError if another run holds it, OSError if it cannot be locked.
    """
    file = folder / ".lock"
    try:
        # SQLite has a lock for every system. The database stays empty.
        with contextlib.closing(sqlite3.connect(file, timeout=0, isolation_level=None, check_same_thread=False)) as lock:
            lock.execute("BEGIN EXCLUSIVE")
            _clear(folder)
            yield
            _clear(folder)
    except sqlite3.OperationalError as error:
        if "locked" in str(error):
            problem = f"another run of {call} writes to this folder, expected one at a time"
            raise BlockingIOError(f"{folder}: {problem}") from None
        raise OSError(f"{file}: cannot be locked: {error}") from None


def _clear(folder: pathlib.Path) -> None:
    """Removes files that `whole` was writing when its process was killed."""
    for left in folder.glob(".*." + 32 * "[0-9a-f]"):
        left.unlink(missing_ok=True)
