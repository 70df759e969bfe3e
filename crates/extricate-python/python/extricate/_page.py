"""The pages of answers that `show` returns."""

from __future__ import annotations

import html
import os
import sys
import tempfile
import webbrowser
from pathlib import Path
from typing import Any, Iterable, Optional, Tuple, Union

PathLike = Union[str, "os.PathLike[str]"]

# Height of a page in a notebook [px].
_HEIGHT = 680


class Page:
    """One self-contained HTML page. Notebooks show it; `save` writes it, `open` shows it in a browser.

    html: text of the page.
    """

    def __init__(self, text: str) -> None:
        self.html = text

    def save(self, path: PathLike) -> Path:
        """Writes the page and returns its path."""
        written = Path(path)
        written.write_text(self.html, encoding="utf-8")
        return written

    def open(self, path: Optional[PathLike] = None) -> Path:
        """Writes the page, to a temporary file if `path` is None, and opens it in the browser of this computer."""
        if path is None:
            handle, path = tempfile.mkstemp(prefix="extricate-", suffix=".html")
            os.close(handle)
        written = self.save(path)
        webbrowser.open(written.resolve().as_uri())
        return written

    def _repr_html_(self) -> str:
        # Without allow-same-origin, scripts of the page cannot reach the notebook.
        text = html.escape(self.html)
        return f'<iframe srcdoc="{text}" sandbox="allow-scripts" style="width: 100%; height: {_HEIGHT}px; border: 0"></iframe>'

    def __repr__(self) -> str:
        return f"<Page of {len(self.html.encode()):,} bytes>"


def table(rows: Iterable[Tuple[str, str]]) -> str:
    """Returns a table of HTML, for notebooks: a name and a text in each row."""
    cells = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>" for name, text in rows)
    return f'<table style="text-align: left">{cells}</table>'


def scene_table(scene: Any) -> str:
    """Returns the table that notebooks show of a scene."""
    rows = [
        ("joints", ", ".join(joint.name for joint in scene.joints)),
        ("coordinates", str(scene.nq)),
        ("bodies", ", ".join(scene.bodies)),
        ("checked pairs", f"{len(scene.pairs):,}"),
        ("clearance", f"{scene.clearance:g} m"),
        ("metric", scene.metric),
        *(("warning", warning) for warning in scene.warnings),
    ]
    return table(rows)


def shown(text: str, path: Optional[PathLike], open_it: Optional[bool]) -> Page:
    """Writes and opens a page, for `show`."""
    page = Page(text)
    if open_it if open_it is not None else not _in_notebook():
        page.open(path)
    elif path is not None:
        page.save(path)
    return page


def _in_notebook() -> bool:
    """Whether the code runs in a notebook, which displays returned objects."""
    ipython: Any = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")
