"""Signatures, the stub and `QueryOptions` list the query options of the library."""

import ast
import dataclasses
import inspect
import pathlib
from typing import Any, Dict

import pytest

import extricate
from extricate import Model, QueryOptions, Scene, Solver
from extricate._extricate import _query_options

TABLE = {name: ast.literal_eval(default) for name, default, _ in _query_options()}
# Keywords that only Python has.
BESIDE = {"options": None, "free": None, "weights": None, "limits": "forgive"}
BATCH = {"errors": "raise", "threads": 0}
STREAM = {"hysteresis": 0.0, "starts_per_frame": 2, "continuous": False}
ONE = {**TABLE, **BESIDE}
FRAMES = {**{name: default for name, default in ONE.items() if name not in ("exits", "toward", "toward_share")}, **STREAM}
STUB = ast.parse((pathlib.Path(extricate.__file__).parent / "_extricate.pyi").read_text(encoding="utf-8"))


def exact(keywords: Dict[str, Any]) -> Dict[str, str]:
    """Makes values comparable so that 1, 1.0 and True differ."""
    return {name: repr(value) for name, value in keywords.items()}


@pytest.mark.parametrize(
    "function, expected",
    [
        (Solver, ONE), (Solver.query, ONE), (Scene.query, ONE), (Model.query, ONE),
        (Solver.batch, {**ONE, **BATCH}), (Scene.query_batch, {**ONE, **BATCH}), (Model.query_batch, {**ONE, **BATCH}),
        (Solver.stream, FRAMES), (Scene.stream, FRAMES), (Model.stream, FRAMES),
    ],
)
def test_signatures_have_the_options_of_the_library(function: Any, expected: Dict[str, Any]) -> None:
    parameters = inspect.signature(function).parameters.values()
    found = {one.name: one.default for one in parameters if one.kind is inspect.Parameter.KEYWORD_ONLY}
    assert exact(found) == exact(expected)


@pytest.mark.parametrize(
    "owner, name, expected",
    [
        ("Solver", "__new__", ONE), ("_Calls", "query", ONE), ("_Calls", "stream", FRAMES),
        ("Solver", "batch", {**ONE, **BATCH}), ("Scene", "query_batch", {**ONE, **BATCH}), ("Model", "query_batch", {**ONE, **BATCH}),
        ("Model", "query", ONE),
    ],
)
def test_the_stub_has_the_options_of_the_library(owner: str, name: str, expected: Dict[str, Any]) -> None:
    (of,) = [node for node in STUB.body if isinstance(node, ast.ClassDef) and node.name == owner]
    *_, function = [node for node in of.body if isinstance(node, ast.FunctionDef) and node.name == name]
    defaults = [ast.literal_eval(default) for default in function.args.kw_defaults if default is not None]
    found = dict(zip([keyword.arg for keyword in function.args.kwonlyargs], defaults))
    assert exact(found) == exact(expected)


def test_the_keywords_of_show_are_those_of_query() -> None:
    (keywords,) = [node for node in STUB.body if isinstance(node, ast.ClassDef) and node.name == "_QueryKeywords"]
    found = [node.target.id for node in keywords.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)]
    assert sorted(found) == sorted(ONE)


def test_the_object_of_options_has_those_of_the_library() -> None:
    fields = {field.name: field.default for field in dataclasses.fields(QueryOptions)}
    assert exact({**fields, "options": None}) == exact(ONE)


def test_a_wrong_option_is_told_as_the_library_tells_it() -> None:
    scene = Scene.builtin("planar-arm")
    expected = {name: text for name, _, text in _query_options()}
    wrong = {"effort": "x", "exits": -1, "starts": 0, "gap": 1.0, "clearance": -1.0, "max_checks": -1, "max_seconds": 0.0}
    for name, value in wrong.items():
        with pytest.raises(ValueError) as raised:
            scene.query([0, 0, 0], **{name: value})  # type: ignore[arg-type]
        assert str(raised.value).startswith(f"{name}: got ") and str(raised.value).endswith(f"expected {expected[name]}")
