"""Pages that `show` writes, opens and returns. scripts/check-view.py checks in a browser how they look."""

import json
import pathlib
import pickle

import numpy as np
import pytest

import extricate


@pytest.fixture()
def opened(monkeypatch: pytest.MonkeyPatch) -> list:
    """Collects the addresses that a browser would open."""
    addresses: list = []
    monkeypatch.setattr("webbrowser.open", addresses.append)
    return addresses


def data_of(page: extricate.Page) -> dict:
    return json.loads(page.html.split('id="data">', 1)[1].split("</script>", 1)[0])


def test_a_page_holds_the_numbers_of_the_answer(tmp_path: pathlib.Path, opened: list) -> None:
    scene = extricate.Scene.builtin("planar-arm")
    q = scene.sample(1, seed=4, colliding=True)[0]
    answer = scene.query(q, exits=2)
    path = tmp_path / "a.html"
    page = answer.show(path=path)
    assert opened == [path.as_uri()] and path.read_text(encoding="utf-8") == page.html
    (shown,) = data_of(page)["answers"]
    assert shown["q"] == q.tolist() and shown["answer"]["depth"] == answer.depth
    assert shown["answer"]["lower_bound"] == answer.lower_bound
    assert [found["depth"] for found in shown["exits"]] == [found.depth for found in answer.exits]


def test_scenes_models_and_solvers_show(opened: list) -> None:
    scene = extricate.Scene.builtin("planar-arm")
    model = extricate.learn(scene, labels=3000)
    Q = scene.sample(2, seed=1, colliding=True)
    for source in (scene, model, model.in_scene(scene)):
        page = source.show(Q, open=False, effort="refined")
        depths = [shown["answer"]["depth"] for shown in data_of(page)["answers"]]
        assert depths == [source.query(q, exits=3).depth for q in Q]
    assert len(data_of(scene.show(open=False))["answers"]) == 5, "random ones where none are given"
    assert opened == []


def test_notebooks_show_the_page_that_is_returned() -> None:
    page = extricate.Scene.builtin("planar-arm").show(open=False)
    inline = page._repr_html_()
    assert inline.startswith("<iframe srcdoc=") and 'sandbox="allow-scripts"' in inline
    assert "<script" not in inline.replace("&lt;script", "")
    assert "bytes" in repr(page)


def test_notebooks_show_answers_and_scenes_as_tables() -> None:
    scene = extricate.Scene.builtin("planar-arm")
    q = scene.sample(1, seed=4, colliding=True)[0]
    answer = scene.query(q)
    shown = answer._repr_html_()
    assert f"<tr><th>depth</th><td>{answer.depth:.4g}, at least {answer.lower_bound:.4g}</td></tr>" in shown
    assert "free: nothing to be done" in scene.query(answer.witness)._repr_html_()
    described = scene._repr_html_()
    assert "<th>joints</th><td>joint_1, joint_2, joint_3</td>" in described and f"<td>{len(scene.pairs)}</td>" in described
    odd = scene.with_obstacles([extricate.Box([1, 1, 1], pose=[9, 9, 9], name="a&b")])
    assert "a&amp;b" in odd._repr_html_(), "names are escaped"


def test_an_answer_pickles_without_its_scene() -> None:
    scene = extricate.Scene.builtin("planar-arm")
    answer = scene.query(scene.sample(1, seed=4, colliding=True)[0])
    bytes_of = pickle.dumps(answer)
    again = pickle.loads(bytes_of)
    assert len(bytes_of) < 5000 and again.depth == answer.depth
    with pytest.raises(RuntimeError, match="does not know its scene"):
        again.show()


def test_what_cannot_be_shown_is_said() -> None:
    scene = extricate.Scene.builtin("planar-arm")
    with pytest.raises(ValueError, match="at most 1000"):
        scene.show(np.zeros((1001, scene.nq)), open=False)
    with pytest.raises(ValueError, match="Q: got shape"):
        scene.show([0.0], open=False)
    with pytest.raises(TypeError, match="unexpected keyword argument 'stream'"):
        scene.show(open=False, stream=True)
