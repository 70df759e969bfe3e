#!/usr/bin/env python3
"""Checks the relative links of pages: `python3 scripts/check-links.py PAGE...`, paths from the root of the repository.

A link has to name a file or folder, and its anchor a heading of that page. Links into the web are not followed.
"""
from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)")


def without_code(text: str) -> str:
    """Returns the same lines, with code left blank."""
    text = re.sub(r"^\s*(`{3,}).*?^\s*\1\s*$", lambda block: "\n" * block[0].count("\n"), text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"`[^`\n]*`", "``", text)


def anchors(page: Path) -> set[str]:
    """Returns the anchors of the headings of a page."""
    found: set[str] = set()
    text = re.sub(r"^\s*(`{3,}).*?^\s*\1\s*$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for heading in re.findall(r"^#+\s+(.*?)\s*#*$", text, re.MULTILINE):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        found.add(re.sub(r"[\s]+", "-", re.sub(r"[^\w\s-]", "", heading.lower()).strip()))
    return found


def faults(page: Path) -> list[str]:
    text = without_code(page.read_text(encoding="utf-8"))
    found = []
    for link in LINK.finditer(text):
        where = f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, link.start()) + 1}"
        target, _, anchor = link[1].partition("#")
        if re.match(r"[a-z]+:", target):
            continue
        path = (page.parent / target).resolve() if target else page
        if not path.exists():
            found.append(f"{where}: {link[1]} does not exist")
        elif anchor and path.suffix == ".md" and anchor not in anchors(path):
            found.append(f"{where}: {link[1]}: no such heading")
    return found


if __name__ == "__main__":
    if not sys.argv[1:]:
        sys.exit(__doc__)
    problems = [fault for name in sys.argv[1:] for fault in faults(ROOT / name)]
    for problem in problems:
        print(problem, file=sys.stderr)
    print(f"{len(sys.argv) - 1} pages, {len(problems)} broken links")
    sys.exit(1 if problems else 0)
