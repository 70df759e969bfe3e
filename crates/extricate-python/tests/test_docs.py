"""`help` describes every class, method, property and field."""

import dataclasses
import inspect

import pytest

import extricate


@pytest.mark.parametrize("name", [name for name in extricate.__all__ if name != "__version__"])
def test_everything_is_described(name: str) -> None:
    thing = getattr(extricate, name)
    page = inspect.getdoc(thing) or ""
    assert len(page) > 20, name
    fields = dataclasses.fields(thing) if dataclasses.is_dataclass(thing) else ()
    for field in fields:
        assert f"\n{field.name}: " in page, f"{name}.{field.name}"
    for member, value in vars(thing).items() if inspect.isclass(thing) else ():
        if not member.startswith("_") and member not in {field.name for field in fields}:
            assert inspect.getdoc(value), f"{name}.{member}"


@pytest.mark.parametrize("function", [extricate.learn, extricate.Model.query, extricate.Model.query_batch, extricate.Model.stream,
                                      extricate.Solver.query, extricate.Solver.batch, extricate.Solver.stream, extricate.Solver.check, extricate.Scene.query, extricate.Scene.check, extricate.Scene.check_segments, extricate.Scene.sample,
                                      extricate.Scene.config, extricate.Scene.positions, extricate.Scene.poses, extricate.Scene.mesh, extricate.Scene.contacts,
                                      extricate.Scene.pair_distances, extricate.Scene.in_world, extricate.import_world, extricate.Scene.colliding_pairs, extricate.Scene.always_colliding,
                                      extricate.rows.run, extricate.rows.read, extricate.rows.batches, extricate.fleet.learn, extricate.fleet.query, extricate.fleet.release,
                                      extricate.grasps.from_arrays, extricate.grasps.to_arrays,
                                      *[getattr(extricate.ros, name) for name in extricate.ros.__all__]])
def test_arguments_are_described_with_their_defaults(function) -> None:  # type: ignore[no-untyped-def]
    page = inspect.getdoc(function) or ""
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name in {"self", "scene"}:
            continue
        named = any(f"{parameter.name}:" in line or f"{parameter.name}," in line for line in page.splitlines())
        assert named, f"{function.__name__}({parameter.name})"
        assert parameter.default is not ..., parameter.name
