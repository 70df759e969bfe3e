"""The manifest of a folder of models: which models it has, by a hash of their input, and which key has which model."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import pathlib
import re
import reprlib
import sys
import tempfile
from typing import Any, Dict, Iterator, List, Mapping

from .._extricate import Model, Scene, __version__

if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


NAME = "manifest.json"
# An empty file that is never removed: otherwise two runs could lock two files of this name.
LOCK = ".manifest.lock"
VERSION = 1
_HASH = re.compile("[0-9a-f]{40}")


def digest(scene: Scene, options: Mapping[str, Any]) -> str:
    """Hashes all that a model depends on: the scene with its geometry, the options, the version of the library."""
    data: bytes = scene.__reduce__()[1][0]
    rest = json.dumps([__version__, sorted(options.items())], default=float)
    return hashlib.blake2b(rest.encode() + b"\0" + data, digest_size=20).hexdigest()


class Manifest:
    """`manifest.json` of a folder. Every change replaces the file at once, so that readers see the old one or the new one.

    Only the run that has `held` the folder writes to it; any number may read.
    """

    def __init__(self, folder: pathlib.Path, *, make: bool = True) -> None:
        """folder: created if it is missing, unless `make` is False."""
        self.folder = folder
        if make:
            folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / NAME
        self._models: Dict[str, Dict[str, Any]] = {}
        self._keys: Dict[str, str] = {}
        self._errors: Dict[str, str] = {}
        if self._file.exists() or not make:
            self._read()

    def _read(self) -> None:
        try:
            found = json.loads(self._file.read_text(encoding="utf-8"))
            _check(found)
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{self._file}: got no manifest of models ({error}), expected what fleet.learn wrote") from None
        self._models, self._keys, self._errors = found["models"], found["keys"], found["errors"]

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Locks the folder for one run. The system unlocks it when the program ends, even by a crash.

        Raises OSError if another run holds it, of this program or of another one.
        """
        file = os.open(self.folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            try:
                _lock(file)
            except (BlockingIOError, PermissionError):
                problem = "another run of fleet.learn writes to this folder, expected one at a time"
                raise BlockingIOError(f"{self.folder}: {problem}") from None
            except OSError as error:
                raise OSError(f"{self.folder / LOCK}: cannot be locked: {error}") from None
            # Another run may have written the manifest before the lock was taken.
            if self._file.exists():
                self._read()
            yield
        finally:
            os.close(file)

    def path(self, content: str) -> pathlib.Path:
        """Returns the path of the model with this hash."""
        return self.folder / f"{content}.model"

    def has(self, content: str) -> bool:
        """Whether the folder has this model and its file can be read: a disk may have spoilt it."""
        known = self._models.get(content)
        try:
            if known is None or self.path(content).stat().st_size != known["bytes"]:
                return False
            Model.load(self.path(content))
        except (OSError, ValueError):
            return False
        return True

    def store(self, content: str, data: bytes, statistics: Mapping[str, Any]) -> None:
        """Writes a model into the folder."""
        _write(self.path(content), data)
        self._models[content] = {"bytes": len(data), "statistics": dict(statistics)}

    def name(self, key: str, content: str) -> None:
        """Sets the model of a key."""
        known = self._keys.get(key) == content and key not in self._errors
        self._keys[key] = content
        self._errors.pop(key, None)
        if not known:
            self._save()

    def fail(self, key: str, error: str) -> None:
        """Notes why a key has no model."""
        self._keys.pop(key, None)
        self._errors[key] = error
        self._save()

    def content(self, key: str) -> str:
        """Returns the hash of a key's model. Raises KeyError if there is none."""
        if key not in self._keys:
            why = self._errors.get(key, "it was never learned")
            raise KeyError(f"{key}: no model in {self.folder}: {why}")
        return self._keys[key]

    def statistics(self, content: str) -> Dict[str, Any]:
        """Returns the statistics of a model, as they were when it was stored."""
        found: Dict[str, Any] = self._models[content]["statistics"]
        return found

    def keys(self) -> List[str]:
        """Returns the keys that have a model."""
        return list(self._keys)

    def errors(self) -> Dict[str, str]:
        """Returns for other keys why they have no model."""
        return dict(self._errors)

    def _save(self) -> None:
        state = {"version": VERSION, "keys": self._keys, "errors": self._errors, "models": self._models}
        _write(self._file, json.dumps(state, indent=1, default=float).encode())


def _check(found: Any) -> None:
    """Raises ValueError if this is no manifest; it names the element, its value and what was expected."""

    def expect(fits: object, element: str, value: Any, expected: str) -> None:
        if not fits:
            raise ValueError(f"{element}: got {reprlib.repr(value)}, expected {expected}")

    expect(isinstance(found, dict), "all of it", found, "an object")
    version = found.get("version")
    expect(type(version) is int and version == VERSION, "version", version, str(VERSION))
    for table in ("models", "keys", "errors"):
        expect(isinstance(found.get(table), dict), table, found.get(table), "an object")
    for content, model in found["models"].items():
        element = f"models: {reprlib.repr(content)}"
        expect(_HASH.fullmatch(content), element, content, "a hash of 40 digits")
        expect(isinstance(model, dict), element, model, "an object")
        expect(type(model.get("bytes")) is int, f"{element}: bytes", model.get("bytes"), "a whole number")
        expect(isinstance(model.get("statistics"), dict), f"{element}: statistics", model.get("statistics"), "an object")
    for key, content in found["keys"].items():
        known = isinstance(content, str) and content in found["models"]
        expect(known, f"keys: {reprlib.repr(key)}", content, "the hash of one of the models")
    for key, error in found["errors"].items():
        expect(isinstance(error, str), f"errors: {reprlib.repr(key)}", error, "text")


def _write(path: pathlib.Path, data: bytes) -> None:
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        pathlib.Path(temporary).unlink(missing_ok=True)
        raise
