#!/usr/bin/env python3
"""Checks the prose of pages and of comments: short sentences, short paragraphs, no retired words.

    python3 scripts/check-prose.py               a table of all pages; exit status 1 where one breaks a rule
    python3 scripts/check-prose.py --self-test   shows that every rule can fail

Rules, for README.md, docs/index.md and all pages in docs/tutorials, docs/how-to and docs/concepts:

- the mean sentence has at most 17 words,
- nine of ten sentences have at most 28 words,
- no paragraph has more than 90 words.

In the same pages and in docs/reference, words that the project has retired are errors, in code blocks too.

In comments and docs of items of all Rust files of crates/:

- no sentence has more than 40 words, and at most 30 sentences in all have more than 30; sources and Python's docs are not counted,
- no doc begins with "Of", "Which" or "That", which are no sentences,
- at most 50 docs have three words or fewer,
- retired words are errors, but for those that are words of the code's own subject.

What counts: paragraphs, list items and block quotes. What does not: headings, tables, code blocks, HTML. Inline code is one word;
of a link, its text counts. An item of a list is a paragraph of its own.
"""
from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import Iterable, NamedTuple

MOST_MEAN, MOST_P90, MOST_PARAGRAPH = 17.0, 28, 90
LONGEST_SENTENCE, LONG_SENTENCE, MOST_LONG_SENTENCES, MOST_SHORT_DOCS = 40, 30, 30, 50
MEASURED = ["README.md", "docs/index.md", "docs/tutorials", "docs/how-to", "docs/concepts"]
SPELLED = [*MEASURED, "docs/reference"]

# Retired words, and the words to use instead.
RETIRED = {
    r"ways? out": "exit",
    r"straight way": "straight segment",
    r"hopes?|hoped|hoping": "prune",
    r"lessons?": "cut",
    r"wander(?:s|ed|ing)?": "random descent",
    r"foot|feet": "projection",
    r"looks": "evaluations, starts per frame",
    r"looked at": "evaluated, tried",
    r"asked": "queried",
    r"told": "reported",
    r"lean": "finding exits only",
    # Retired as a noun for multistart; "a column that turns", "turns up" and "full turns" are other words.
    r"in turns|takes? turns|taking turns|turns of (?:starts|descents)|(?:several|many|more|few|fewer|all|\d+) turns": "one after another",
    # Retired as a noun for the classifier of a pair; a computer is a machine.
    r"(?:all|pairs?|pairs?'s?) machines?|(?<!vector )machines? (?:of|for) (?:a|all|each|every|the|one) pairs?|machines? a pair": "classifier",
}
RETIRED_PATTERN = re.compile("|".join(rf"(?P<w{at}>\b(?:{word})\b)" for at, word in enumerate(RETIRED)), re.IGNORECASE)

FENCE = re.compile(r"^\s*(`{3,}|~{3,})(.*)$")
ITEM = re.compile(r"^(\s*)(?:[-*+]|\d+[.)])\s+")
ABBREVIATIONS = {"e.g.", "i.e.", "etc.", "vs.", "cf.", "fig.", "no.", "approx.", "et", "al.", "doi.", "sec."}
WORD = re.compile(r"[^\W_]")
CODE = "Xcode"


class Block(NamedTuple):
    """A paragraph or an item of a list: its first line and its text."""

    line: int
    text: str


class Figures(NamedTuple):
    """Measured figures of a page."""

    sentences: list[int]
    longest: int
    longest_line: int

    @property
    def mean(self) -> float:
        return sum(self.sentences) / len(self.sentences) if self.sentences else 0.0

    @property
    def p90(self) -> int:
        """Returns the least length that nine of ten sentences do not exceed."""
        ordered = sorted(self.sentences)
        return ordered[math.ceil(0.9 * len(ordered)) - 1] if ordered else 0


def blocks(text: str) -> Iterable[Block]:
    """Returns the paragraphs and list items of a page, in order."""
    lines = text.splitlines()
    gathered: list[str] = []
    start = 0
    fence = ""
    in_comment = in_list = False
    blank_before = True

    def flush() -> Iterable[Block]:
        if gathered:
            yield Block(start, " ".join(gathered))
            gathered.clear()

    at = 0
    if lines and lines[0] == "---":  # front matter
        at = next((k + 1 for k, line in enumerate(lines[1:], 1) if line == "---"), 0)
    for number, line in enumerate(lines[at:], at + 1):
        opened = FENCE.match(line)
        if fence:
            if opened and opened[1].startswith(fence) and not opened[2].strip():
                fence = ""
            continue
        if in_comment or line.lstrip().startswith("<!--"):
            in_comment = "-->" not in line
            yield from flush()
            continue
        if opened:
            fence = opened[1]
            yield from flush()
            continue
        stripped = line.strip()
        if not stripped:
            yield from flush()
            blank_before = True
            continue
        is_indented = line.startswith("    ") and not in_list
        item = ITEM.match(line)
        if stripped.startswith(("#", "|", "<", "!!!", "???", "===")) or re.fullmatch(r"[-=*_ ]{3,}", stripped):
            yield from flush()
        elif is_indented and blank_before and not item:
            pass  # This is a block of code without a fence.
        elif is_indented and not gathered and not item:
            pass
        else:
            if item:
                yield from flush()
                in_list = True
                line = line[item.end():]
            elif blank_before and not line.startswith(" "):
                in_list = False
            if not gathered:
                start = number
            gathered.append(line.strip().lstrip("> "))
        blank_before = False
    yield from flush()


def plain(text: str) -> str:
    """Reduces a block to prose: inline code as one word, links as their text, no marks."""
    text = re.sub(r"(`+)(?:(?!\1).)+?\1", CODE, text)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"\[([^\]]*)\]\[[^\]]*\]", r"\1", text)
    text = re.sub(r"<https?://[^>]*>|https?://\S+", "address", text)
    text = re.sub(r"</?[a-zA-Z][^>]*>", "", text)
    return re.sub(r"\*+|(?<!\w)_+|_+(?!\w)", "", text)


def sentences(text: str) -> list[str]:
    """Splits a block of prose into sentences."""
    found, begin = [], 0
    for end in re.finditer(r"[.!?]+[\"')\]]*\s+(?=[\"'(\[]*[A-Z0-9])", text):
        last = text[begin : end.end()].split()[-1].lower() if text[begin : end.end()].split() else ""
        if last in ABBREVIATIONS or re.fullmatch(r"[a-z]\.", last):
            continue
        found.append(text[begin : end.end()])
        begin = end.end()
    found.append(text[begin:])
    return [sentence.strip() for sentence in found if words(sentence)]


def words(text: str) -> int:
    """Counts words; a dash or a percent sign alone is none."""
    return sum(1 for token in text.split() if WORD.search(token))


def measure(text: str) -> Figures:
    """Measures the figures of a page."""
    lengths: list[int] = []
    longest, longest_line = 0, 0
    for block in blocks(text):
        prose = plain(block.text)
        lengths += [words(sentence) for sentence in sentences(prose)]
        if words(prose) > longest:
            longest, longest_line = words(prose), block.line
    return Figures(lengths, longest, longest_line)


def faults(name: str, figures: Figures) -> list[str]:
    """Returns violations of the rules of length, one line each."""
    found = []
    if figures.mean > MOST_MEAN:
        found.append(f"{name}: {figures.mean:.1f} words a sentence in the mean, expected at most {MOST_MEAN:.0f}")
    if figures.p90 > MOST_P90:
        found.append(f"{name}: one sentence in ten has {figures.p90} words or more, expected at most {MOST_P90}")
    if figures.longest > MOST_PARAGRAPH:
        found.append(f"{name}:{figures.longest_line}: a paragraph of {figures.longest} words, expected at most {MOST_PARAGRAPH}")
    return found


def retired(name: str, text: str) -> list[str]:
    """Returns retired words, one line each. Words that a line break parts are found too."""
    found = []
    instead = list(RETIRED.values())
    hidden = re.sub(r"\]\([^)]*\)", lambda link: re.sub(r"\S", " ", link[0]), text)
    for match in RETIRED_PATTERN.finditer(re.sub(r"[ \t]*\n[ \t]*(?=\S)", lambda gap: " " * len(gap[0]), hidden)):
        line = text.count("\n", 0, match.start()) + 1
        which = int(str(match.lastgroup)[1:])
        found.append(f"{name}:{line}: \"{' '.join(match[0].split())}\" is retired, expected: {instead[which]}")
    return found


def pages(root: Path, names: list[str]) -> tuple[list[Path], list[str]]:
    """Returns the pages that `names` (files and folders) stand for, and missing names."""
    found: list[Path] = []
    missing = []
    for name in names:
        path = root / name
        here = sorted(path.rglob("*.md")) if path.is_dir() else [path] if path.is_file() else []
        if not here:
            missing.append(f"{name}: no page, expected at least one")
        found += here
    return found, missing


COMMENT = re.compile(r"^\s*//([/!]?)(?: (.*)|)$")
FRAGMENT = re.compile(r"^(?:Of|Which|That)\b")


def comments(text: str) -> Iterable[tuple[int, str, list[str]]]:
    """Yields the comments of a Rust file: the first line, the kind (`/`, `!` or nothing), and the lines."""
    start, kind, gathered = 0, "", []
    for number, line in enumerate(text.splitlines() + [""], 1):
        match = COMMENT.match(line)
        if gathered and (not match or match[1] != kind):
            yield start, kind, gathered
            gathered = []
        if match:
            if not gathered:
                start, kind = number, match[1]
            gathered.append(match[2] or "")


def comment_figures(name: str, text: str) -> tuple[list[str], list[str], list[str]]:
    """Returns faults, long sentences and short docs of the comments of a Rust file, a line each."""
    found, long, short = [], [], []
    for start, kind, lines in comments(text):
        body = "\n".join(line for line in lines if not line.startswith("# "))
        # Python's docs list their arguments one a line.
        body = re.sub(r"\n(?=[\w`*, ]{1,40}: )", "\n\n", body)
        first = next(iter(blocks(body)), None)
        for block in blocks(body):
            # Docs of Python are signatures and lists in part, and a source has its own form.
            is_prose = "doi:" not in block.text and not name.startswith("crates/extricate-python")
            for sentence in sentences(plain(block.text)) if is_prose else ():
                if words(sentence) > LONG_SENTENCE:
                    long.append(f"{name}:{start}: a sentence of {words(sentence)} words, expected at most {LONG_SENTENCE}")
                if words(sentence) > LONGEST_SENTENCE:
                    found.append(long[-1])
        if kind and first and FRAGMENT.match(first.text):
            found.append(f"{name}:{start}: a doc that begins \"{first.text[:30]}\", expected a sentence")
        if kind == "/" and len(lines) == 1 and first and words(first.text) <= 3 and not first.text.startswith("See [`"):
            short.append(f"{name}:{start}: a doc of {words(first.text)} words: {first.text}")
        found += [re.sub(r":\d+:", f":{start}:", fault, count=1) for fault in retired(name, plain(body))]
    return found, long, short


def check_comments(root: Path) -> tuple[int, list[str]]:
    """Returns how many files were read, and their problems."""
    problems, long, short = [], [], []
    files = sorted(path for path in root.glob("crates/**/*.rs") if "target" not in path.parts)
    for path in files:
        each = comment_figures(str(path.relative_to(root)), path.read_text(encoding="utf-8"))
        for kept, more in zip((problems, long, short), each):
            kept += more
    if len(long) > MOST_LONG_SENTENCES:
        problems += long
    if len(short) > MOST_SHORT_DOCS:
        problems += short
    print(f"comments: {len(long)} sentences of more than {LONG_SENTENCE} words, {len(short)} docs of at most three words")
    return len(files), problems


def check(root: Path) -> int:
    measured, missing = pages(root, MEASURED)
    spelled, also_missing = pages(root, SPELLED)
    problems = list(dict.fromkeys(missing + also_missing))
    width = max((len(str(page.relative_to(root))) for page in measured), default=4)
    print(f"{'page':<{width}}  mean  90 %  longest paragraph")
    for page in measured:
        name = str(page.relative_to(root))
        figures = measure(page.read_text(encoding="utf-8"))
        print(f"{name:<{width}}  {figures.mean:4.1f}  {figures.p90:4d}  {figures.longest:4d}")
        problems += faults(name, figures)
    for page in spelled:
        problems += retired(str(page.relative_to(root)), page.read_text(encoding="utf-8"))
    files, in_comments = check_comments(root)
    problems += in_comments
    for problem in problems:
        print(problem, file=sys.stderr)
    print(f"{len(measured)} pages measured, {len(spelled)} spelled, {files} Rust files, {len(problems)} problems")
    return 1 if problems else 0


def self_test() -> int:
    """Tests pages with known figures and known faults."""
    short = "A robot is free. It stays so.\n"
    long_sentence = "word " * 40 + "ends.\n"
    paragraph = " ".join(["Five words are in here."] * 19) + "\n"
    page = (
        "# A heading with many words that does not count\n\n"
        "One two three `a b c` five.\nSix [seven eight](there.md#a-b) e.g. nine. 1.5 is 3. Ends here!\n\n"
        "| a table | of words |\n|---|---|\n| that do not | count at all |\n\n"
        "```sh\na line of code that is long, long, long, long and is no sentence.\n```\n\n"
        "    indented code that is no sentence either and has no end\n\n"
        "- an item\n- another item\n  that goes on\n\n    and more of it\n\n"
        "<!-- a comment -->\n\n> quoted words\n"
    )
    cases = [
        ("lengths of sentences", measure(page).sentences, [5, 5, 3, 2, 2, 5, 4, 2]),
        ("the longest paragraph", (measure(page).longest, measure(page).longest_line), (15, 3)),
        ("a good page", faults("p", measure(short)) + retired("p", short), []),
        ("a mean that is too long", [f for f in faults("p", measure(long_sentence)) if "mean" in f] != [], True),
        ("one sentence in ten that is too long", [f for f in faults("p", measure(long_sentence + "\n" + "Short.\n\n" * 5)) if "ten" in f] != [], True),
        ("nine of ten are short", faults("p", measure(long_sentence + "\n" + "Short.\n\n" * 9)), []),
        ("a paragraph that is too long", faults("p", measure(paragraph)), ["p:1: a paragraph of 95 words, expected at most 90"]),
        ("a retired word", retired("p", "Fine.\n\nThe way out.\n"), ['p:3: "way out" is retired, expected: exit']),
        ("a retired word over a line break", len(retired("p", "both ways\nout of it")), 1),
        ("retired words in code", len(retired("p", "```sh\nextricate query --looks 2\n```")), 1),
        ("words that only hold a retired one", retired("p", "a boolean, footnotes, a fold that turns up, turns into clean code, of full turns; hopeless"), []),
        ("a computer is a machine", retired("p", "The speed of the machine."), []),
        ("a classifier is none", len(retired("p", "Support vectors of all machines; the machine of a pair.")), 2),
        ("addresses are no words", retired("p", "[here](../asked.md#ways-out)"), []),
    ]
    rust = "/// Of both.\nfn a() {}\n// It was asked.\n/// Returns the number of all.\n/// " + "word " * 41 + "ends.\n"
    found, long, short = comment_figures("p", rust)
    cases.append(("comments of Rust", (len(found), len(long), len(short)), (3, 1, 1)))
    for word in ("ways out", "hope", "lesson", "wander", "foot", "feet", "looks", "looked at", "asked", "told", "lean", "in turns"):
        cases.append((f"the word {word}", len(retired("p", f"So {word} is.")), 1))
    wrong = [(name, got, expected) for name, got, expected in cases if got != expected]
    for name, got, expected in wrong:
        print(f"self-test: {name}: got {got}, expected {expected}", file=sys.stderr)
    print(f"self-test: {len(cases)} cases, {len(wrong)} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    if sys.argv[1:] == ["--self-test"]:
        sys.exit(self_test())
    if sys.argv[1:]:
        sys.exit(__doc__)
    sys.exit(check(Path(__file__).resolve().parent.parent))
