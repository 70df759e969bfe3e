#!/usr/bin/env python3
"""What queries miss on scenes that nobody chose: scenes drawn at random and the named ones, for docs/benchmarks/search.md.

    target/peers/bin/python bench/search.py --scenes 'boxes-*' 'carts-8-*' shelf-arm --labels 20000,400000 --seeds 1,2,3 [--queries 200] [--jobs 2] [--write]
    target/peers/bin/python bench/search.py --program new=target/release --program old=OTHER/target/release     an older build beside this one

Needs cargo and numpy (bench/requirements.txt). Scenes of the fetched robots are there once scripts/fetch-robots.py was run. Scenes are those of `extricate-bench draw` with each of --draws, those of bench/scenes.py and the built-in ones.

Every program learns a model of each scene for each number of labels and seed, and answers the same random colliding configurations at each effort. Best known is
the least depth that anything of these found: all programs, labels, seeds and efforts, of this run and of earlier ones in the cache; of carts it is the closed form. Depths
within a hundred-thousandth of a radian of the best count as equal to it. Times are processor time of one thread; with several --jobs they are of a busy machine.

The cache holds queries and answers by the contents of the scene, the queries, the two programs and everything else that they depend on: a rerun does what is missing.
"""
import argparse
import concurrent.futures
import fnmatch
import pathlib
import shlex
import sys

import programs
import search_cells as cells
import search_report as report
from page import put
from sides import BUILD, ROBOTS, ROOT


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=["*"], metavar="PATTERN", help="names, with * and ? as in file names; a drawn scene's ends in its seed")
    parser.add_argument("--labels", default="20000,400000", help="as `learn` takes; `default` is what it takes without --labels; `none` asks without a model, `robot` with one of 2,000 labels of the scene without its obstacles")
    parser.add_argument("--seeds", default="1", help="of learning")
    parser.add_argument("--draws", default="1", help="seeds of the drawn scenes")
    parser.add_argument("--efforts", default="refined,exhaustive", help="as `extricate-bench query` takes")
    parser.add_argument("--queries", type=int, default=200, help="of each scene")
    parser.add_argument("--sampling", type=int, default=41, help="seed of the queries")
    parser.add_argument("--program", action="append", metavar="NAME=DIR", help="folder of a built extricate and extricate-bench; the first draws scenes and queries. Else cargo builds them")
    parser.add_argument("--robots", type=pathlib.Path, default=ROBOTS if ROBOTS.is_dir() else None, help="fetched robots; by default those of scripts/fetch-robots.py")
    parser.add_argument("--jobs", type=int, default=1, help="models learned and asked at a time, on one thread each")
    parser.add_argument("--cache", type=pathlib.Path, default=BUILD / "search")
    parser.add_argument("--keep-models", action="store_true", help="leave models in the cache; a run with other efforts or queries need not learn them again")
    parser.add_argument("--list", action="store_true", help="print the scenes and do no more")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks/search.md")
    return parser.parse_args()


def programs_of(words):
    """Returns name and folder of every program; the other benchmarks use the first one too."""
    if not words:
        programs.build()
        return {"extricate": pathlib.Path(programs.folder)}
    found = {}
    for word in words:
        name, _, folder = word.partition("=")
        if not name or not (pathlib.Path(folder) / "extricate-bench").is_file():
            sys.exit(f"--program {word}: expected NAME=DIR with extricate and extricate-bench in DIR")
        found[name] = pathlib.Path(folder).resolve()
    if len({cells.programs_key(folder) for folder in found.values()}) < len(found):
        sys.exit("--program: two folders hold the same programs")
    programs.folder = next(iter(found.values()))
    return found


def chosen(options):
    """Returns the files of the requested scenes, by name."""
    known = cells.scenes(options.cache / "scenes", numbers(options.draws), options.robots)
    found = {name: path for name, path in known.items() if any(fnmatch.fnmatchcase(name, pattern) for pattern in options.scenes)}
    for pattern in options.scenes:
        if not any(fnmatch.fnmatchcase(name, pattern) for name in known):
            sys.exit(f"--scenes {pattern}: there is no such scene; --list names them")
    return found


def command():
    """Returns the command that reproduces this run, without the folders of this machine."""
    named = ("--program", "--cache", "--robots")
    words = [word.split("=")[0] + "=DIR" if before == "--program" else "DIR" if before in named else word for before, word in zip(["", *sys.argv[1:]], sys.argv[1:])]
    return f"python bench/search.py {shlex.join(words)}"


def numbers(text):
    return [int(word) for word in text.split(",")]


def main():
    options = arguments()
    tried, found = programs_of(options.program), chosen(options)
    if options.list:
        print("\n".join(found))
        return
    labels, seeds, efforts = options.labels.split(","), numbers(options.seeds), options.efforts.split(",")
    queries = {name: cells.queries(options.cache, scene, options.queries, options.sampling) for name, scene in found.items()}
    todo = [cells.Cell(name, scene, queries[name], program, folder, count, seed) for name, scene in found.items() for program, folder in tried.items() for count in labels for seed in seeds]
    answers = {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        running = {pool.submit(cells.answers, options.cache, cell, efforts, options.keep_models): cell for cell in todo}
        for done in concurrent.futures.as_completed(running):
            cell = running[done]
            answers[cell] = done.result()
            print(f"{len(answers)}/{len(todo)} {cell.name} {cell.program} {cell.labels} labels, seed {cell.seed}", flush=True)
    text = report.section(answers, queries, cells.earlier(options.cache, queries), options, command())
    print(text)
    if options.write:
        put(ROOT / "docs/benchmarks/search.md", "bench/search.py", text, "What queries miss, measured")


if __name__ == "__main__":
    main()
