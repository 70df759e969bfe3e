#!/usr/bin/env python3
"""Writes docs/reference/command-line.md from what the program says of itself.

    python3 scripts/write-cli-reference.py target/debug/extricate            writes the page
    python3 scripts/write-cli-reference.py target/debug/extricate --check    fails where the page is not what it would write
"""
from __future__ import annotations

import difflib
import os
import re
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs/reference/command-line.md"
HEAD = """# Command line

<!-- Written by scripts/write-cli-reference.py from `extricate --help`; do not edit. -->

What `extricate --help` and `extricate COMMAND --help` print. The keys of `--json`, and the spellings of input, are in [JSON](json.md); exit codes
are in [limits and exit codes](limits-and-exit-codes.md).
"""


def help_of(program: str, *words: str) -> str:
    """Returns the output of `--help`, the same in terminals of any width."""
    environment = dict(os.environ, COLUMNS="100", NO_COLOR="1", TERM="dumb")
    done = subprocess.run(
        [program, *words, "--help"],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=True,
    )
    return "\n".join(line.rstrip() for line in done.stdout.strip().splitlines())


def commands(text: str) -> list[str]:
    """Returns the names of the groups between `Usage:` and `Options:`, in order."""
    listed = re.search(r"^Usage:.*?\n((?:.*\n)*?)Options:", text, re.MULTILINE)
    names = re.findall(r"^  (\w[\w-]*)", listed[1], re.MULTILINE) if listed else []
    if not names:
        sys.exit("the program lists no commands")
    return names


def page(program: str) -> str:
    top = help_of(program)
    parts = [HEAD, f"## `extricate`\n\n```text\n{top}\n```\n"]
    parts += [f"## `extricate {name}`\n\n```text\n{help_of(program, name)}\n```\n" for name in commands(top)]
    return "\n".join(parts)


def main() -> int:
    arguments = [word for word in sys.argv[1:] if word != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    wanted = page(str(Path(arguments[0]).resolve()))
    if "--check" not in sys.argv:
        PAGE.write_text(wanted, encoding="utf-8")
        print(f"wrote {PAGE}")
        return 0
    found = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    if found == wanted:
        return 0
    sys.stderr.writelines(difflib.unified_diff(found.splitlines(True), wanted.splitlines(True), "the page", "the program"))
    print(f"{PAGE} is not what {arguments[0]} says: run scripts/write-cli-reference.py {arguments[0]}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
