"""Runs the Python blocks of pages as they are printed: `python readme.py PAGE...`, in the working directory."""

import pathlib
import re
import sys


def blocks(page: str) -> list:  # type: ignore[type-arg]
    return re.findall(r"```python\n(.*?)```", pathlib.Path(page).read_text(encoding="utf-8"), re.DOTALL)


if __name__ == "__main__":
    for page in sys.argv[1:]:
        found = blocks(page)
        if not found:
            sys.exit(f"{page}: no Python block")
        for code in found:
            exec(compile(code, page, "exec"), {"__name__": "__main__"})
