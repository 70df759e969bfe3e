"""What a folder of models holds: models by the hash of what they were learned from, and which key means which."""

from __future__ import annotations

import hashlib
import json
import os
import pathlib
import tempfile
from typing import Any, Dict, List, Mapping

from .._extricate import Scene, __version__

NAME = "manifest.json"
VERSION = 1


def digest(scene: Scene, options: Mapping[str, Any]) -> str:
    """A hash of all that a model depends on: the scene with its geometry, the options, the version of the library."""
    data: bytes = scene.__reduce__()[1][0]
    rest = json.dumps([__version__, sorted(options.items())], default=float)
    return hashlib.blake2b(rest.encode() + b"\0" + data, digest_size=20).hexdigest()


class Manifest:
    """`manifest.json` of a folder, written anew after every change: another reader sees the old one or the whole new one.

    One run at a time writes to a folder; any number may read.
    """

    def __init__(self, folder: pathlib.Path, *, make: bool = True) -> None:
        """folder: made where it is missing, unless `make` is False."""
        self.folder = folder
        if make:
            folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / NAME
        self._models: Dict[str, Dict[str, Any]] = {}
        self._keys: Dict[str, str] = {}
        self._errors: Dict[str, str] = {}
        if self._file.exists() or not make:
            self._read(self._file.read_text(encoding="utf-8"))

    def _read(self, text: str) -> None:
        try:
            found = json.loads(text)
            if found["version"] != VERSION:
                raise ValueError(f"version: got {found['version']}, expected {VERSION}")
            self._models, self._keys, self._errors = found["models"], found["keys"], found["errors"]
        except (KeyError, TypeError, json.JSONDecodeError) as error:
            raise ValueError(f"{self._file}: got no manifest of models ({error!r}), expected what fleet.learn wrote") from None
        except ValueError as error:
            raise ValueError(f"{self._file}: {error}") from None

    def path(self, content: str) -> pathlib.Path:
        """Of the model of this hash."""
        return self.folder / f"{content}.model"

    def has(self, content: str) -> bool:
        """Whether there is such a model, as long as when it was stored."""
        known = self._models.get(content)
        try:
            return known is not None and self.path(content).stat().st_size == known["bytes"]
        except OSError:
            return False

    def store(self, content: str, data: bytes, statistics: Mapping[str, Any]) -> None:
        """Keeps a model."""
        _write(self.path(content), data)
        self._models[content] = {"bytes": len(data), "statistics": dict(statistics)}

    def name(self, key: str, content: str) -> None:
        """Says which model a key means."""
        known = self._keys.get(key) == content and key not in self._errors
        self._keys[key] = content
        self._errors.pop(key, None)
        if not known:
            self._save()

    def fail(self, key: str, error: str) -> None:
        """Says why a key has no model."""
        self._keys.pop(key, None)
        self._errors[key] = error
        self._save()

    def content(self, key: str) -> str:
        """The hash of a key's model. Raises KeyError where there is none."""
        if key not in self._keys:
            why = self._errors.get(key, "it was never learned")
            raise KeyError(f"{key}: no model in {self.folder}: {why}")
        return self._keys[key]

    def statistics(self, content: str) -> Dict[str, Any]:
        """As they were when the model was stored."""
        found: Dict[str, Any] = self._models[content]["statistics"]
        return found

    def keys(self) -> List[str]:
        """Those that have a model."""
        return list(self._keys)

    def errors(self) -> Dict[str, str]:
        """Why others have none."""
        return dict(self._errors)

    def checkpoint(self, content: str) -> Dict[str, str]:
        """Where a run of this model keeps itself. Workers use it where they see the folder: not every cluster shares one."""
        folder = self.folder.resolve()
        return {"folder": str(folder), "checkpoint": str(folder / f"{content}.checkpoint")}

    def _save(self) -> None:
        state = {"version": VERSION, "keys": self._keys, "errors": self._errors, "models": self._models}
        _write(self._file, json.dumps(state, indent=1, default=float).encode())


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
