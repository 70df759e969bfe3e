"""Hooks of mkdocs: pages outside docs/ and references made of sources become part of the site, and links to them lead there.

ARCHITECTURE.md and CHANGELOG.md stay at the root of the repository, where people look for them. Links to other files outside
docs/, such as sources and licences, become their paths as text: the site has no such pages.
"""
from __future__ import annotations

import os
import posixpath
import re
import shutil
import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import header_reference  # noqa: E402

SHOWN = {"ARCHITECTURE.md": "internals/architecture.md", "CHANGELOG.md": "changelog.md"}
# The live page that scripts/write-live-page.sh wrote, which the first page of the site shows.
LIVE = ROOT / "target/live-demo.html"
# The reference of Rust that scripts/build-site.sh wrote.
RUSTDOC = ROOT / "target/rustdoc/doc"
RUST = """# Rust

<a href="../rust/extricate/index.html">The crate `extricate`</a>: every public name, with examples. It has a search of its own.
`cargo doc -p extricate --open` shows the same.
"""
NOT_RUST = """# Rust

This copy of the documentation was built without the reference of the crate. In the folder of the repository, `cargo doc -p extricate --open`
shows it.
"""
NOT_LIVE = """<!doctype html><html lang="en"><meta charset="utf-8"><title>extricate</title>
<img src="../images/demo.webp" alt="An arm in collision with a post, and its way to the nearest free configuration" style="max-width: 100%">
<p style="font: 16px sans-serif">This copy of the documentation was built without the live demo
(<code>scripts/write-live-page.sh</code>). <code>extricate demo</code> writes a page like it.</p></html>
"""
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")


def on_config(config: Any, **_: Any) -> Any:
    address = re.search(r'^homepage = "(.*)"', (ROOT / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)
    # The placeholder is no address.
    if address and "OWNER" not in address[1]:
        config.site_url = address[1]
    return config


def on_post_build(config: Any, **_: Any) -> None:
    if RUSTDOC.exists():
        shutil.copytree(RUSTDOC, Path(config.site_dir) / "rust", dirs_exist_ok=True)


def on_files(files: Any, config: Any, **_: Any) -> Any:
    for name, uri in SHOWN.items():
        files.append(File.generated(config, uri, abs_src_path=str(ROOT / name)))
    for language in header_reference.FILES:
        files.append(File.generated(config, f"reference/{language}.md", content=header_reference.page(language)))
    files.append(File.generated(config, "reference/rust.md", content=RUST if RUSTDOC.exists() else NOT_RUST))
    if LIVE.exists():
        files.append(File.generated(config, "live/demo.html", abs_src_path=str(LIVE)))
    else:
        files.append(File.generated(config, "live/demo.html", content=NOT_LIVE))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    uri = page.file.src_uri
    place = next((name for name, shown in SHOWN.items() if shown == uri), f"docs/{uri}")

    def lead(link: re.Match[str]) -> str:
        text, target, anchor = link[1], link[2], link[3] or ""
        if re.match(r"[a-z]+:", target):
            return link[0]
        path = posixpath.normpath(posixpath.join(posixpath.dirname(place), target))
        if path in SHOWN:
            return f"[{text}]({relative(SHOWN[path], uri)}{anchor})"
        if path.startswith("docs/"):
            return f"[{text}]({relative(path[len('docs/'):], uri)}{anchor})"
        # A missing target stays a link, for which mkdocs warns.
        return f"{text} (`{path}`)" if (ROOT / path).exists() and text.strip("`") != path else f"`{path}`" if (ROOT / path).exists() else link[0]

    # The highlighter does not know options of rustdoc as languages.
    return re.sub(r"^(\s*```rust),\S+", r"\1", LINK.sub(lead, markdown), flags=re.MULTILINE)


def relative(target: str, uri: str) -> str:
    return os.path.relpath(target, posixpath.dirname(uri) or ".").replace(os.sep, "/")
