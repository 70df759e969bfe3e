"""Makes the pages of C and C++ from the comments of the headers, for the hooks of mkdocs.

What is read: comments (`//` in C, `///` in C++) and the declaration that follows each. Namespaces `detail`, private members and bodies
of functions are left out. `python3 scripts/header_reference.py` prints the pages.
"""
from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

INCLUDE = Path(__file__).resolve().parent.parent / "crates/extricate-c/include"
HEAD = {
    "c": "# C\n\nEverything in `extricate.h`. [Use it from C and C++](../how-to/cpp.md) says how to build with it.\n",
    "cpp": "# C++\n\nEverything in `extricate.hpp` and `extricate_moveit.hpp`, namespace `extricate`. [Use it from C and C++](../how-to/cpp.md)\n"
    "says how to build with it.\n",
}
FILES = {"c": ["extricate.h"], "cpp": ["extricate.hpp", "extricate_moveit.hpp"]}
BLOCK = re.compile(r'(?:template <.*?> )?(?:typedef )?(?:(extern "C")|(namespace|class|struct|union|enum class|enum)\b ?([\w:]*))')


@dataclass
class Item:
    """A declaration with its comment, and those in it."""

    code: str
    doc: str
    kind: str = ""
    name: str = ""
    inner: list["Item"] = field(default_factory=list)


class Reader:
    """Reads the declarations of one header."""

    def __init__(self, text: str, mark: str) -> None:
        self.mark, self.at = mark, 0
        # Lines that end with a backslash are one, and the comment at the head of the file is shown apart.
        text = text.replace("\\\n", " ")
        self.head = ""
        if found := re.match(r"/\*(.*?)\*/", text, re.DOTALL):
            self.head = "\n".join(re.sub(r"^ ?\* ?", "", line) for line in found[1].strip().splitlines())
            text = text[found.end() :]
        self.text = text

    def items(self, is_public: bool = True) -> list[Item]:
        """Returns what stands up to the end of the text, or to the brace that closes the block."""
        found: list[Item] = []
        doc: list[str] = []
        while self.at < len(self.text):
            rest = self.text[self.at :]
            line = rest.split("\n", 1)[0]
            if space := re.match(r"\s+|/\*.*?\*/", rest, re.DOTALL):
                if space[0].count("\n") > 1:
                    doc = []
                self.at += space.end()
            elif rest.startswith("//"):
                comment = re.match(rf"{self.mark}(?!/) ?(.*)", line)
                doc = [*doc, comment[1]] if comment else []
                self.at += len(line)
            elif rest.startswith("#"):
                if (constant := re.match(r"#define (\w+) (\S.*)", line)) and doc:
                    found.append(Item(line, "\n".join(doc), "constant", constant[1]))
                doc = []
                self.at += len(line)
            elif access := re.match(r"(public|private|protected):", rest):
                is_public = access[1] == "public"
                self.at += access.end()
            elif rest[0] == "}":
                self.at += 1
                return found
            else:
                item = self.declaration("\n".join(doc))
                doc = []
                if is_public and item and item.name != "detail":
                    found.append(item)
        return found

    def declaration(self, doc: str) -> Item | None:
        """Reads one declaration, and what is in it if it is a class or a namespace."""
        start, depth = self.at, 0
        while self.at < len(self.text):
            letter = self.text[self.at]
            if letter in "([":
                depth += 1
            elif letter in ")]":
                depth -= 1
            elif letter == ";" and depth == 0:
                code = self.text[start : self.at]
                self.at += 1
                return declared(code, doc)
            elif letter == "{" and depth == 0:
                code = self.text[start : self.at]
                self.at += 1
                block = BLOCK.match(" ".join(code.split()))
                if block and (block[1] or block[2] == "namespace"):
                    return Item("", "", "namespace", block[3], self.items())
                if block and "(" not in code:
                    if block[2].startswith("enum"):
                        body = self.skip_braces()
                        self.after_block()
                        return Item(tidy(f"{code.strip()} {{{body}}}"), doc, "type", block[3])
                    inner = self.items(is_public=block[2] != "class")
                    self.after_block()
                    return Item(tidy(code), doc, "type", block[3], inner)
                self.skip_braces()
                # A brace of an initialiser is part of the declaration; that of a body ends it.
                if re.match(r"\s*[;,{]", self.text[self.at :]) and not code.rstrip().endswith((")", "const", "noexcept")):
                    continue
                if re.match(r"\s*;", self.text[self.at :]):
                    self.after_block()
                return declared(code, doc)
            self.at += 1
        return None

    def skip_braces(self) -> str:
        """Goes behind the brace that closes the one before; returns what is between them."""
        start, depth = self.at, 1
        while depth and self.at < len(self.text):
            # Braces in texts and comments close nothing.
            if inert := re.match(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|//[^\n]*', self.text[self.at :]):
                self.at += inert.end()
                continue
            depth += {"{": 1, "}": -1}.get(self.text[self.at], 0)
            self.at += 1
        return self.text[start : self.at - 1]

    def after_block(self) -> None:
        """Goes behind the name and the semicolon after a block."""
        end = re.match(r"\s*\w*\s*;", self.text[self.at :])
        self.at += end.end() if end else 0


def tidy(code: str) -> str:
    code = re.sub(r"\[\[nodiscard\]\]|EXTRICATE_MUST_CHECK|\binline\b|\bexplicit\b(?= \w+\()", "", code)
    lines = [line.rstrip() for line in code.strip().splitlines()]
    return re.sub(r" {2,}(?=\S)", " ", lines[0]) + "".join("\n" + line for line in lines[1:])


def declared(code: str, doc: str) -> Item | None:
    # What a constructor sets is no part of its declaration.
    flat = " ".join(code.split())
    if not flat or re.match(r"(friend|static_assert|using namespace|return)\b", flat) or "= delete" in flat or ("= default" in flat and not doc):
        return None
    code = re.sub(r"\)\s*:\s*(?!:).*$", ")", code, flags=re.DOTALL) if re.search(r"\)\s*:\s*(?!:)", code) else code
    name = re.search(r"(\w+|operator\S+?) *\(", code) or re.search(r"using (\w+)", code) or re.search(r"(\w+)(?:\[\w+\])?\s*(?:=.*)?$", code.strip(), re.DOTALL)
    return Item(tidy(code) + ";", doc, "member", name[1] if name else "")


def prose(doc: str) -> str:
    # Code of a comment stands four columns in, as in Markdown; tags would vanish.
    return re.sub(r"<(?=\w)", "&lt;", doc)


def shown(items: list[Item], level: int, out: list[str], language: str) -> None:
    for item in items:
        if item.kind == "namespace":
            shown(item.inner, level, out, language)
        elif item.kind == "type":
            out.append(f"{'#' * level} {item.name}\n")
            if item.doc:
                out.append(prose(item.doc) + "\n")
            if item.inner or "{" in item.code:
                out.append(f"```{language}\n{item.code}\n```\n")
            shown(item.inner, level + 1, out, language)
        else:
            out.append(f"```{language}\n{item.code}\n```\n")
            if item.doc:
                out.append(prose(item.doc) + "\n")


def page(language: str) -> str:
    """Returns the page of `c` or `cpp` in Markdown."""
    out = [HEAD[language]]
    for name in FILES[language]:
        reader = Reader((INCLUDE / name).read_text(encoding="utf-8"), "//" if language == "c" else "///")
        items = reader.items()
        out.append(f"## {name}\n\n{prose(reader.head)}\n")
        shown(items, 3, out, language)
    text = "\n".join(out)
    if language == "c":
        code = re.sub(r"//.*", "", (INCLUDE / "extricate.h").read_text(encoding="utf-8"))
        missing = [name for name in sorted(set(re.findall(r"\bextricate_\w+(?=\()", code))) if f"{name}(" not in text]
        assert not missing, f"functions of extricate.h that were not read: {missing}"
    return text


if __name__ == "__main__":
    for chosen in FILES:
        print(page(chosen))
