#!/usr/bin/env python3
"""Makes docs/images/demo.png and demo.webp, with which README.md begins, from a page of the program.

    pip install pillow
    python3 scripts/write-hero.py target/release/extricate

The page shows one query of the built-in arm before a shelf. The animation is three seconds of it: the query, the way to the nearest exit,
the exit. Needs Chromium.
"""
from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path

import chromium
from PIL import Image
from view_pages import Program, expect, opened

IMAGES = Path(__file__).resolve().parent.parent / "docs/images"
WIDTH, HEIGHT = 1240, 640
# A query whose collision and way out are seen at once.
SEED, QUERY = 3, 3
FRAMES, MILLISECONDS, REST = 24, 70, 700
MOST_BYTES = 1_000_000


def main() -> None:
    program = Program(sys.argv[1], Path(tempfile.mkdtemp()))
    browser = chromium.find()
    expect(browser, "there is no Chromium here")
    program.run("demo --export cell")
    with chromium.Browser(str(browser), WIDTH, HEIGHT) as page:
        opened(page, program, f"cell/shelf-arm.toml -n {QUERY + 1} --seed {SEED} --effort exhaustive --exits 2")
        page.run(f"document.getElementById('queries').hidden = true; extricate.controls.choose({QUERY})")
        frames = []
        for at in range(FRAMES + 1):
            page.run(f"extricate.controls.go({100 * at / FRAMES}); extricate.stage.drawAt(true)")
            page.picture(IMAGES / "demo.png")
            frames.append(Image.open(io.BytesIO((IMAGES / "demo.png").read_bytes())).convert("RGB"))
        page.run("extricate.controls.go(0); extricate.stage.drawAt(true)")
        page.picture(IMAGES / "demo.png")
    times = [REST, *[MILLISECONDS] * (FRAMES - 1), REST]
    frames[0].save(IMAGES / "demo.webp", save_all=True, append_images=frames[1:], duration=times, loop=0, quality=72, method=6)
    for name in ("demo.png", "demo.webp"):
        size = (IMAGES / name).stat().st_size
        expect(size <= MOST_BYTES, f"{name} has {size} bytes, at most {MOST_BYTES}")
        print(f"{name}: {size} bytes")


if __name__ == "__main__":
    main()
