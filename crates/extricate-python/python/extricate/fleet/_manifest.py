"""The manifest of a folder of models: which models it has, by a hash of their input, and which key has which model."""

from __future__ import annotations

import contextlib
import json
import pathlib
import re
import reprlib
import sqlite3
import urllib.parse
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple

from .._extricate import Model
from .._folder import held, whole

NAME = "manifest.sqlite"
VERSION = 1
_HASH = re.compile("[0-9a-f]{40}")
# A key has a model or an error.
_TABLES = """
CREATE TABLE models (content TEXT PRIMARY KEY, bytes INTEGER NOT NULL, statistics TEXT NOT NULL);
CREATE TABLE keys (key TEXT PRIMARY KEY, content TEXT, error TEXT);
"""


class Manifest:
    """`manifest.sqlite` of a folder. Only the run that has `held` the folder writes to it; any number may read."""

    def __init__(self, folder: pathlib.Path, *, make: bool = True) -> None:
        """folder: created if it is missing, unless `make` is False."""
        self.folder = folder
        self._file = folder / NAME
        if make:
            folder.mkdir(parents=True, exist_ok=True)
        elif not self._file.exists():
            raise FileNotFoundError(f"{self._file}: no such file, expected a folder of fleet.learn")
        self._open(writes=False)

    def _open(self, writes: bool) -> None:
        self._database: Optional[sqlite3.Connection] = None
        if writes or self._file.exists():
            address = f"file:{urllib.parse.quote(str(self._file.absolute()))}?mode={'rwc' if writes else 'ro'}"
            self._database = sqlite3.connect(address, uri=True, isolation_level=None, check_same_thread=False)
            (version,) = self._rows("PRAGMA user_version")[0]
            if writes and version == 0 and not self._rows("SELECT 1 FROM sqlite_master"):
                self._database.executescript(f"BEGIN;{_TABLES}PRAGMA user_version = {VERSION};COMMIT")
            elif version != VERSION:
                raise self._fault(f"version: got {version}, expected {VERSION}")
            # Tables that are missing are found now, not in the middle of a run.
            self._rows("SELECT content, bytes, statistics FROM models LIMIT 0")
            self._rows("SELECT key, content, error FROM keys LIMIT 0")

    def _fault(self, problem: str) -> ValueError:
        return ValueError(f"{self._file}: got no manifest of models ({problem}), expected what fleet.learn wrote")

    def _rows(self, command: str, *values: Any) -> List[Tuple[Any, ...]]:
        if self._database is None:
            return []
        try:
            return self._database.execute(command, values).fetchall()
        except sqlite3.OperationalError as error:
            if "no such" not in str(error):
                raise OSError(f"{self._file}: {error}") from None
            raise self._fault(str(error)) from None
        except sqlite3.DatabaseError as error:
            raise self._fault(str(error)) from None

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Locks the folder for one run, which may write. Raises OSError if another run holds it."""
        with held(self.folder, "fleet.learn"):
            self._close()
            self._open(writes=True)
            try:
                # A change costs no wait for the disk, and readers see it at once. If power fails, the last changes may be lost.
                self._rows("PRAGMA journal_mode = WAL")
                self._rows("PRAGMA synchronous = NORMAL")
                yield
            finally:
                # One file is left, which can also be read where nothing may be written. Readers of this moment prevent that.
                self._rows("PRAGMA busy_timeout = 0")
                with contextlib.suppress(OSError):
                    self._rows("PRAGMA journal_mode = DELETE")
                self._close()

    def _close(self) -> None:
        if self._database:
            self._database.close()
        self._database = None

    def path(self, content: str) -> pathlib.Path:
        """Returns the path of the model with this hash."""
        return self.folder / f"{content}.model"

    def has(self, content: str) -> bool:
        """Whether the folder has this model and its file can be read: a disk may have spoilt it."""
        known = self._rows("SELECT bytes FROM models WHERE content = ?", content)
        try:
            if not known or self.path(content).stat().st_size != known[0][0]:
                return False
            Model.load(self.path(content))
        except (OSError, ValueError):
            return False
        return True

    def store(self, content: str, data: bytes, statistics: Mapping[str, Any]) -> None:
        """Writes a model into the folder."""
        with whole(self.path(content)) as file:
            file.write(data)
        self.note(content, len(data), statistics)

    def note(self, content: str, size: int, statistics: Mapping[str, Any]) -> None:
        """Notes that the folder has a model of so many bytes."""
        row = (content, size, json.dumps(dict(statistics), default=float))
        self._rows("INSERT OR REPLACE INTO models VALUES (?, ?, ?)", *row)

    def name(self, key: str, content: str) -> None:
        """Sets the model of a key."""
        self._set(key, content, None)

    def fail(self, key: str, error: str) -> None:
        """Notes why a key has no model."""
        self._set(key, None, error)

    def _set(self, key: str, content: Optional[str], error: Optional[str]) -> None:
        known = self._rows("SELECT content, error FROM keys WHERE key = ?", key)
        if known != [(content, error)]:
            command = "INSERT INTO keys VALUES (?, ?, ?) ON CONFLICT (key) DO UPDATE SET content = excluded.content, error = excluded.error"
            self._rows(command, key, content, error)

    def content(self, key: str) -> str:
        """Returns the hash of a key's model. Raises KeyError if there is none."""
        found = self._rows("SELECT content, error FROM keys WHERE key = ?", key)
        if not found or found[0][0] is None:
            why = found[0][1] if found else "it was never learned"
            raise KeyError(f"{key}: no model in {self.folder}: {why}")
        content = found[0][0]
        if not isinstance(content, str) or not _HASH.fullmatch(content):
            raise self._fault(f"keys: {reprlib.repr(key)}: got {reprlib.repr(content)}, expected a hash of 40 digits")
        return content

    def statistics(self, content: str) -> Dict[str, Any]:
        """Returns the statistics of a model, as they were when it was stored."""
        stored = self._rows("SELECT statistics FROM models WHERE content = ?", content)
        try:
            found = json.loads(stored[0][0])
        except (IndexError, RecursionError, TypeError, ValueError):
            found = None
        if not isinstance(found, dict):
            raise self._fault(f"models: {content}: got {reprlib.repr(stored)}, expected an object as statistics")
        return found

    def keys(self) -> List[str]:
        """Returns the keys that have a model."""
        return [key for (key,) in self._rows("SELECT key FROM keys WHERE error IS NULL ORDER BY rowid")]

    def has_key(self, key: object) -> bool:
        """Whether a key has a model."""
        return bool(self._rows("SELECT 1 FROM keys WHERE key = ? AND error IS NULL", key)) if isinstance(key, str) else False

    def size(self) -> int:
        """Returns how many keys have a model."""
        counted = self._rows("SELECT COUNT(*) FROM keys WHERE error IS NULL")
        return int(counted[0][0]) if counted else 0

    def errors(self) -> Dict[str, str]:
        """Returns for other keys why they have no model."""
        return dict(self._rows("SELECT key, error FROM keys WHERE error IS NOT NULL ORDER BY rowid"))
