"""Shared functions of the checks of pages: opening a page, reading it, and comparing it with the program."""
from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import chromium

# Counts pixels of the canvas in the hue of collisions, in that of free robots, and off the background.
PIXELS = """(() => {
    const from = extricate.stage.renderer.domElement, to = document.createElement("canvas");
    extricate.stage.drawAt(false);
    to.width = from.width; to.height = from.height;
    const context = to.getContext("2d");
    context.drawImage(from, 0, 0);
    const data = context.getImageData(0, 0, to.width, to.height).data;
    let hit = 0, free = 0, drawn = 0, sum = 0;
    for (let at = 0; at < data.length; at += 4) {
        const [r, g, b] = [data[at], data[at + 1], data[at + 2]];
        if (r > 1.5 * g && g > 1.3 * b) hit++;
        if (b > 1.25 * g && g > 1.4 * r) free++;
        if (Math.abs(r - 238) + Math.abs(g - 241) + Math.abs(b - 245) > 60) drawn++;
        sum = (31 * sum + r + 3 * g + 7 * b) % 4294967296;
    }
    return { hit, free, drawn, sum };
})()"""
NUMBERS = """Object.fromEntries([...document.querySelectorAll("#panel [data-key]")]
    .map(found => [found.dataset.key, found.dataset.value]))"""
# The label of the vertical axis of the plot, and the parts of that of the horizontal axis.
AXES = """(([upright, level]) => [upright.textContent, [...level.children].map(part => part.textContent)])(
    document.querySelectorAll("#plotted .axis"))"""
JOINTS = """["query", "exit"].map(key => [...document.querySelectorAll(`#joints [data-joint=${key}]`)]
    .map(cell => Number(cell.dataset.value)))"""


def expect(holds: object, text: str) -> None:
    if not holds:
        raise AssertionError(text)


def go(page: chromium.Browser, percent: int) -> Any:
    page.run(f"extricate.controls.go({percent})")
    return page.run(PIXELS)


def check_pictures(page: chromium.Browser, folder: Path, name: str) -> None:
    seen = []
    for percent in (0, 50, 100):
        pixels = go(page, percent)
        page.picture(folder / f"{name}-{percent}.png")
        expect(pixels["drawn"] > 5000, f"{name} at {percent} %: the picture is empty: {pixels}")
        seen.append(pixels)
    expect(len({pixels["sum"] for pixels in seen}) == 3, f"{name}: pictures along the slider are the same: {seen}")
    expect(seen[0]["hit"] > 200, f"{name}: nothing is in the colour of collisions at the query: {seen[0]}")
    expect(seen[2]["free"] > 1000 and seen[2]["free"] > 4 * seen[0]["free"], f"{name}: the exit is not shown as free: {seen}")


def check_numbers(page: chromium.Browser, rows: list[dict[str, Any]]) -> int:
    """Compares the numbers of the page with lines of `query --json`; returns how many were compared."""
    compared = 0
    for at, row in enumerate(rows):
        page.run(f"extricate.controls.choose({at})")
        shown = page.run(NUMBERS)
        # A free configuration has no further numbers.
        names = ["depth"] if row["depth"] == 0 else ["depth", "lower_bound", "gap", "max_displacement", "verified", "clearance", "unique", "checks", "effort"]
        names += [name for name in ("unseen",) if row["depth"] > 0 and row[name] is not None]
        for name in names:
            value = json.loads(shown[name]) if name != "effort" else shown[name]
            expect(value == row[name], f"query {at + 1}: {name}: the page has {value}, the program {row[name]}")
        for name in ("colliding", "touching") if row["depth"] > 0 else ():
            expect(json.loads(shown[name]) == row[name], f"query {at + 1}: {name}: {shown[name]} {row[name]}")
        for number, found in enumerate(row.get("exits", [])):
            page.run(f"extricate.controls.pick({number})")
            _, witness = page.run(JOINTS)
            expect(witness == found["witness"], f"query {at + 1}, exit {number + 1}: {witness} {found['witness']}")
            shown = page.run(NUMBERS)
            depth = json.loads(shown["exit_depth" if number else "depth"])
            expect(depth == found["depth"], f"query {at + 1}, exit {number + 1}: {depth} {found['depth']}")
            compared += 1 + len(witness)
        compared += len(names) + 2
    return compared


def check_keys(page: chromium.Browser) -> None:
    page.run("extricate.controls.choose(0); extricate.controls.go(0); document.activeElement.blur()")
    state = "[extricate.controls.query, extricate.controls.exit, extricate.controls.percent]"
    for keys, expected in ((["ArrowRight"] * 3, [0, 0, 3]), (["End"], [0, 0, 100]), (["Home"], [0, 0, 0]), (["n"], [1, 0, 0]), (["p"], [0, 0, 0])):
        for key in keys:
            page.press(key)
        found = page.run(state)
        expect(found == expected, f"after {keys}: got {found}, expected {expected}")


def check_words(page: chromium.Browser) -> None:
    unexplained = page.run("""[...document.querySelectorAll("#numbers .word")].filter(word => !word.title).map(word => word.textContent)""")
    expect(not unexplained, f"words that the page does not explain: {unexplained}")
    page.run("document.querySelector('#numbers .word').click()")
    expect(page.run("document.querySelectorAll('#numbers .meaning').length") == 1, "a word that is pressed does not say what it means")


def check_clean(page: chromium.Browser, name: str, address: str) -> None:
    expect(not page.errors, f"{name}: errors on the console: {page.errors}")
    asked = [url for url in page.requests if url != address and not url.startswith(("data:", "blob:"))]
    expect(not asked, f"{name}: the page asks for {asked}")


class Program:
    """Runs the command line in a folder."""

    def __init__(self, program: str, folder: Path) -> None:
        self.program, self.folder = str(Path(program).resolve()), folder

    def run(self, line: str) -> str:
        done = subprocess.run([self.program, *line.split()], cwd=self.folder, capture_output=True, text=True)
        expect(done.returncode == 0, f"extricate {line}: {done.stderr}")
        return done.stdout

    def rows(self, line: str) -> list[dict[str, Any]]:
        return [json.loads(text) for text in self.run(line).splitlines()]


def opened(page: chromium.Browser, extricate: Program, line: str) -> str:
    extricate.run(f"view {line} -o page.html")
    address = (extricate.folder / "page.html").as_uri()
    page.open(address)
    return address
