"""Writes parts of pages under docs/benchmarks: tables, plots, and the text between two markers."""
try:
    import matplotlib
except ImportError:  # Only pages with plots need it.
    pass
else:
    matplotlib.use("Agg")
    matplotlib.rcParams |= {"svg.hashsalt": "extricate", "svg.fonttype": "none", "font.size": 9}


def table(head, rows):
    lines = ["| " + " | ".join(map(str, head)) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def number(x):
    """Formats a number with three digits, without exponents."""
    return "" if x is None else f"{x:,.0f}" if abs(x) >= 100 else f"{x:.3g}"


def put(page, part, text, title):
    """Replaces the text between the markers of `part` on `page`; other text stays as it is."""
    begin, end = f"<!-- measured: begin ({part}) -->", f"<!-- measured: end ({part}) -->"
    old = page.read_text() if page.exists() else f"# {title}\n"
    if begin not in old:
        old = f"{old.rstrip()}\n\n{begin}\n{end}\n"
    head, rest = old.split(begin)
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text(f"{head}{begin}\n\n{text.strip()}\n\n{end}{rest.split(end)[1]}")
    print(page)


def save(figure, path):
    """Saves a plot as SVG without the date and trailing blanks, so that equal figures are equal files."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
    path.write_text("\n".join(line.rstrip() for line in path.read_text().splitlines()) + "\n")
