#!/usr/bin/env python3
"""Runs what the pages show: Python blocks of README.md, tutorials and how-to, and `extricate` lines of README.md and the tutorials.

    python3 scripts/check-doc-blocks.py PROGRAM PYTHON [PAGE...]
    python3 scripts/check-doc-blocks.py --self-test

PROGRAM is an `extricate` program, or `-` where there is none: `extricate` lines are then skipped. PYTHON is an interpreter that has
the package, or `-`: Python blocks are then skipped.

One page runs in one temporary folder, from top to bottom:

- a block with `title="NAME"` is written to NAME;
- ```python blocks run in one namespace, and none prints `None`: what a page shows is the good case;
- of ```sh blocks of README.md and the tutorials, the lines that run `extricate` run in bash, each with the lines that continue it;
- a block after a line `<!-- not run -->` is skipped.

The first failure of a page ends it and is reported with file and line.
"""
from __future__ import annotations

import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
NOT_RUN = "<!-- not run -->"
FENCE = re.compile(r"^(\s*)(`{3,})\s*(.*?)\s*$")
TITLE = re.compile(r'title="([^"]+)"')
SECONDS = 600

# The program that PYTHON runs; it reads the steps of a page from standard input.
RUNNER = r"""
import contextlib, io, json, subprocess, sys, traceback
namespace = {"__name__": "__main__"}
for step in json.load(sys.stdin):
    where = f"{step['page']}:{step['line']}"
    try:
        if step["kind"] == "file":
            with open(step["name"], "w", encoding="utf-8") as file:
                file.write(step["text"])
        elif step["kind"] == "python":
            with contextlib.redirect_stdout(io.StringIO()) as printed:
                exec(compile("\n" * step["line"] + step["text"], step["page"], "exec"), namespace)
            if "None" in printed.getvalue().splitlines():
                sys.exit(f"{where}: the block prints None")
        else:
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", step["text"]], stdin=subprocess.DEVNULL)
            if done.returncode:
                sys.exit(f"{where}: exit status {done.returncode}: {step['text']}")
    except Exception:
        traceback.print_exc()
        sys.exit(f"{where}: the block fails")
"""


def steps(page: str, text: str) -> list[dict[str, Any]]:
    """Returns the steps of a page, in order."""
    found: list[dict[str, Any]] = []
    lines = text.splitlines()
    at, last = 0, ""
    while at < len(lines):
        opened = FENCE.match(lines[at])
        if not opened:
            last = lines[at].strip() or last
            at += 1
            continue
        indent, fence, info = opened.groups()
        first = at + 1
        at = first
        while at < len(lines) and lines[at].strip() != fence:
            at += 1
        body = [line.removeprefix(indent) for line in lines[first:at]]
        at += 1
        is_run, last = last != NOT_RUN, ""
        if not is_run:
            continue
        language, title = re.split(r"[\s,{]", info, maxsplit=1)[0], TITLE.search(info)
        if title:
            found.append({"kind": "file", "page": page, "line": first, "name": title[1], "text": "\n".join(body) + "\n"})
        elif language == "python":
            found.append({"kind": "python", "page": page, "line": first, "text": "\n".join(body) + "\n"})
        elif language == "sh":
            found += [{"kind": "sh", "page": page, "line": first + 1 + k, "text": line} for k, line in commands(body)]
    return found


def commands(body: list[str]) -> list[tuple[int, str]]:
    """Returns the lines that run `extricate`, with those that continue them."""
    found, at = [], 0
    while at < len(body):
        begin, line = at, body[at]
        while line.rstrip().endswith(("\\", "|")) and at + 1 < len(body):
            at += 1
            line = f"{line}\n{body[at]}"
        if re.search(r"(?:^|[|&;]\s*)extricate\s", line):
            found.append((begin, line))
        at += 1
    return found


def pages() -> list[Path]:
    return [ROOT / "README.md", *sorted((ROOT / "docs/tutorials").glob("*.md")), *sorted((ROOT / "docs/how-to").glob("*.md"))]


def wanted(page: Path, program: str, python: str) -> list[dict[str, Any]]:
    """Returns the steps of a page that can be run."""
    name = str(page.relative_to(ROOT)) if page.is_relative_to(ROOT) else str(page)
    with_program = program != "-" and (name == "README.md" or "tutorials/" in name or not page.is_relative_to(ROOT))
    kinds = {"file"} | ({"sh"} if with_program else set()) | ({"python"} if python != "-" else set())
    found = [step for step in steps(name, page.read_text(encoding="utf-8")) if step["kind"] in kinds]
    return found if any(step["kind"] != "file" for step in found) else []


def run(page: Path, program: str, python: str) -> tuple[int, int]:
    """Runs a page; returns the number of its steps, and the exit status."""
    todo = wanted(page, program, python)
    if not todo:
        return 0, 0
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ)
        if program != "-":
            # Pages call the program by its name alone.
            (Path(folder) / ".bin").mkdir()
            (Path(folder) / ".bin/extricate").symlink_to(Path(program).resolve())
            environment["PATH"] = f"{folder}/.bin{os.pathsep}{environment['PATH']}"
        interpreter = sys.executable if python == "-" else os.path.abspath(python)
        done = subprocess.run([interpreter, "-c", RUNNER], input=json.dumps(todo), text=True, cwd=folder, env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=SECONDS)
    if done.returncode:
        print(done.stdout, file=sys.stderr, end="")
    return len(todo), done.returncode


def check(chosen: list[Path], program: str, python: str) -> int:
    failed, total = 0, 0
    for page in chosen:
        count, status = run(page, program, python)
        total, failed = total + count, failed + (status != 0)
        print(f"{'ok' if status == 0 else 'FAILED':<7} {count:3d} steps  {page.relative_to(ROOT) if page.is_relative_to(ROOT) else page}")
    if not total:
        print("no page has anything to run", file=sys.stderr)
        return 1
    print(f"{len(chosen)} pages, {total} steps, {failed} pages failed")
    return 1 if failed else 0


def self_test() -> int:
    """Tests pages with known steps, and pages that have to fail."""
    page = "\n".join(['```toml title="a.toml"', "x = 1", "```", "", "```python", "y = open('a.toml').read()", "```", NOT_RUN, "", "```python", "1 / 0", "```",
                      "```sh", "pip install x", "extricate --version |", "  cat", "echo a | extricate info - \\", "    --json", "```", "```python", "assert y == 'x = 1\\n'", "```", "```text", "extricate", "```"])
    kinds = [(step["kind"], step["line"]) for step in steps("p", page)]
    expected = [("file", 1), ("python", 5), ("sh", 15), ("sh", 17), ("python", 20)]
    wrong = [] if kinds == expected else [f"got {kinds}, expected {expected}"]
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program"
        program.write_text("#!/bin/sh\ncat > /dev/null\n[ \"$1\" != fail ]\n")
        program.chmod(0o755)
        for name, text, status in [("good", page, 0), ("python", page.replace("x = 1\\n", "x"), 1), ("sh", "```sh\nextricate fail\n```", 1), ("python2", "```python\nraise ValueError\n```", 1), ("none", "```python\nprint(None)\n```", 1)]:
            path = Path(folder) / f"{name}.md"
            path.write_text(text)
            with contextlib.redirect_stderr(io.StringIO()):
                count, got = run(path, str(program), sys.executable)
            if got != status or not count:
                wrong.append(f"{name}: got exit status {got} of {count} steps, expected {status}")
    for fault in wrong:
        print(f"self-test: {fault}", file=sys.stderr)
    print(f"self-test: 6 cases, {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments == ["--self-test"]:
        sys.exit(self_test())
    if len(arguments) < 2:
        sys.exit(__doc__)
    sys.exit(check([Path(page).resolve() for page in arguments[2:]] or pages(), arguments[0], arguments[1]))
