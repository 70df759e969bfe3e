"""Models: learning, queries, files and threads."""

import io
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import extricate
from extricate import Model, Progress, Scene


def test_answers_are_free_and_bounded(model: Model, planar: Scene) -> None:
    Q = planar.sample(100, seed=8, colliding=True)
    for effort in ["nearest", "refined", "exhaustive"]:
        answers = [model.query(q, effort=effort, contacts=True) for q in Q[:20]]
        for q, answer in zip(Q, answers):
            assert planar.check(answer.witness) and answer.witness.shape == (3,)
            assert 0 <= answer.lower_bound <= answer.depth
            turned = (answer.witness - q + np.pi) % (2 * np.pi) - np.pi  # One joint is continuous.
            assert answer.depth == pytest.approx(np.linalg.norm(turned), abs=1e-9)
            assert answer.effort == effort and answer.verified == (effort != "nearest")
            assert answer.colliding == planar.colliding_pairs(q) and not answer.free
            assert answer.max_displacement > 0 and answer.checks > 0
            assert set(answer.touching) <= set(planar.pairs)
    free = model.query(planar.sample(1, colliding=False)[0])
    assert free.free and free.depth == 0 and free.colliding == [] and free.verified


@pytest.mark.parametrize("effort", ["nearest", "refined"])
def test_a_batch_says_what_single_queries_say(model: Model, planar: Scene, effort: str) -> None:
    Q = planar.sample(300, seed=4)
    for threads in [1, 2]:
        batch = model.query_batch(Q, effort=effort, threads=threads)
        assert batch.shape == (300,) and batch["witness"].shape == (300, 3)
        for q, row in zip(Q, batch):
            one = model.query(q, effort=effort)
            for field in ["depth", "lower_bound", "max_displacement", "checks", "verified", "free", "unique"]:
                assert row[field] == getattr(one, field), field
            np.testing.assert_array_equal(row["witness"], one.witness)
            np.testing.assert_array_equal(row["gradient"], one.gradient)
    assert batch["verified"].dtype == bool and batch["checks"].dtype == np.int64
    assert planar.check(batch["witness"]).all()
    np.testing.assert_array_equal(batch["free"], planar.check(Q))


def test_exits_contacts_and_the_way_are_told(model: Model, planar: Scene) -> None:
    checks = checks_of_one_start = 0
    for q in planar.sample(20, seed=9, colliding=True):
        answer = model.query(q, exits=3, segment=True)
        assert 1 <= len(answer.exits) <= 3
        np.testing.assert_array_equal(answer.exits[0].witness, answer.witness)
        depths = [found.depth for found in answer.exits]
        assert depths == sorted(depths) and depths[0] == answer.depth
        assert all(planar.check(found.witness) for found in answer.exits)
        assert answer.segment is not None and 0 <= answer.segment[0] <= answer.segment[1] <= 1
        assert {contact.pair for contact in answer.contacts} == set(answer.touching)
        for contact in answer.contacts:
            assert contact.points.shape == (2, 3) and np.linalg.norm(contact.normal) == pytest.approx(1)
            first, second = contact.points
            np.testing.assert_allclose((first - second) @ contact.normal, contact.distance, atol=1e-9)
        # In the joint metric with unit weights, the distance falls fastest straight toward the witness.
        turned = (answer.witness - q + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(answer.gradient, -turned / answer.depth, atol=1e-6)
        # The checks are equal if all other starts are too far to be tried.
        whole, fewer = model.query(q), model.query(q, starts=1)
        assert planar.check(fewer.witness) and fewer.checks <= whole.checks and fewer.verified
        checks, checks_of_one_start = checks + whole.checks, checks_of_one_start + fewer.checks
        less = model.query(q, max_checks=20)
        assert less.depth >= whole.depth and less.verified and not less.exits and less.segment is None
    assert checks_of_one_start < 0.8 * checks, (checks_of_one_start, checks)


def test_a_stream_follows(model: Model, planar: Scene) -> None:
    start = planar.sample(1, seed=10, colliding=True)[0]
    stream = model.stream(hysteresis=0.1)
    for k in range(30):
        q = start + [0.001 * k, 0, 0]
        answer = stream.query(q)
        assert planar.check(answer.witness) and answer.lower_bound <= answer.depth
        assert answer.depth <= 1.5 * model.query(q).depth + 1e-6
    short = model.stream(max_checks=5, starts=2, segment=True).query(start)
    assert planar.check(short.witness) and short.depth >= model.query(start).depth and short.segment is not None
    stream.restart()
    assert stream.query(start).depth == model.stream().query(start).depth
    elsewhere = model.in_scene(planar)
    for k in range(5):
        there = stream.query(start + [0.001 * k, 0, 0], scene=elsewhere)
        assert there is not None and there.verified and planar.check(there.witness)
    with pytest.raises(ValueError, match="scene: got one of other coordinates"):
        stream.query(start, scene=extricate.Solver(Scene.builtin("hand")))
    samples = model.statistics["boundary_samples"]
    assert repr(stream) == f"<Stream of a model of {samples} boundary samples, hysteresis 0.1>"


def test_answers_are_printed_for_people(model: Model, planar: Scene) -> None:
    q = planar.sample(1, seed=9, colliding=True)[0]
    answer = model.query(q, exits=3)
    lines = str(answer).splitlines()
    assert [line.split()[0] for line in lines] == ["depth", "witness", "moves", "colliding", "touching"] + ["exit"] * (len(answer.exits) - 1)
    assert lines[0] == f"depth      {answer.depth:.4g}, at least {answer.lower_bound:.4g}"
    assert lines[1].endswith("], verified") and " - ".join(answer.colliding[0]) in lines[3]
    nearest = model.query(q, effort="nearest")
    assert "when the model was learned" in str(nearest) and "touching" not in str(nearest)
    told = model.query(q, effort="nearest", contacts=True)
    assert nearest.colliding[0] in told.colliding == answer.colliding and nearest.contacts == nearest.touching == []
    assert told.depth == nearest.depth and told.touching == sorted({contact.pair for contact in told.contacts})
    assert str(model.query(planar.sample(1, colliding=False)[0])) == "free: nothing to be done"
    assert repr(answer).startswith("Answer(depth=")


def test_a_batch_of_one_or_none(model: Model) -> None:
    assert model.query_batch(np.zeros((0, 3))).shape == (0,)
    assert model.query_batch(np.zeros((1, 3))).shape == (1,)
    assert model.query_batch(np.zeros(3)).shape == (1,)


def test_batches_do_not_copy_their_input(arm: Scene) -> None:
    model = extricate.learn(arm, labels=2000)
    Q = np.zeros((200_000, 7))
    before = peak_memory()
    model.query_batch(Q, effort="nearest", threads=2)
    # The limit is below the answers (160 bytes each) and a copy (56 bytes) together.
    assert peak_memory() - before < 200_000 * (160 + 28) + 8e6


def peak_memory() -> float:
    resource = pytest.importorskip("resource")
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def test_learning_tells_and_can_be_ended(planar: Scene) -> None:
    seen = []
    model = extricate.learn(planar, labels=250_000, progress=lambda state: seen.append(state))
    assert model.statistics["ended_by"] == "labels" and model.statistics["labels"] > 200_000
    assert {state.stage for state in seen} <= {"exploring", "training", "tracing the boundary", "solving", "measuring"}
    fractions = [state.fraction for state in seen]
    assert fractions == sorted(fractions) and fractions[-1] == pytest.approx(1, abs=1e-3)
    assert "Progress(stage=" in repr(seen[0])

    ended = extricate.learn(planar, labels=10**9, progress=lambda state: state.boundary_samples < 100)
    assert ended.statistics["ended_by"] == "interruption"
    assert ended.query(planar.sample(1, colliding=True)[0]).verified

    def fail(state: Progress) -> None:
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        extricate.learn(planar, labels=10**9, progress=fail)


def test_a_bar_is_drawn_on_a_terminal_alone(planar: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    class Screen(io.StringIO):
        terminal = True

        def isatty(self) -> bool:
            return self.terminal

    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    extricate.learn(planar, labels=50_000)
    assert "100" in screen.getvalue()
    for terminal, progress in ((True, False), (False, None)):
        screen = Screen()
        screen.terminal = terminal
        monkeypatch.setattr(sys, "stderr", screen)
        extricate.learn(planar, labels=50_000, progress=progress)
        assert screen.getvalue() == ""


def test_a_bar_is_drawn_with_and_without_tqdm(planar: Scene, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("tqdm")
    extricate.learn(planar, labels=50_000, progress=True)
    assert "100%" in capfd.readouterr().err
    monkeypatch.setitem(__import__("sys").modules, "tqdm.auto", None)
    extricate.learn(planar, labels=50_000, progress=True)
    assert "100 %" in capfd.readouterr().err
    extricate.learn(planar, labels=1000)
    assert capfd.readouterr() == ("", "")


def test_the_same_seed_gives_the_same_model(planar: Scene, model: Model) -> None:
    again = extricate.learn(planar, labels=20_000, seed=3, threads=1)
    assert again.to_bytes() == model.to_bytes()
    assert extricate.learn(planar, labels=20_000, seed=4).to_bytes() != model.to_bytes()


def test_models_are_kept_and_pickled(model: Model, planar: Scene, tmp_path) -> None:  # type: ignore[no-untyped-def]
    model.save(tmp_path / "m.model")
    q = planar.sample(1, seed=5, colliding=True)[0]
    for again in [Model.load(tmp_path / "m.model"), pickle.loads(pickle.dumps(model)), Model.from_bytes(model.to_bytes())]:
        assert again.query(q).depth == model.query(q).depth
        assert again.statistics == model.statistics and again.scene.pairs == planar.pairs
    np.testing.assert_array_equal(again.boundary, model.boundary)
    assert planar.check(model.boundary).all() and len(model.boundary) == model.statistics["boundary_samples"]
    answer = pickle.loads(pickle.dumps(model.query(q)))
    assert repr(answer) == repr(model.query(q)) and answer.colliding == model.query(q).colliding and not answer.free

    (tmp_path / "scene.toml").write_text("clearance = 0")
    with pytest.raises(OSError, match="it exists and is no model"):
        model.save(tmp_path / "scene.toml")
    with pytest.raises(OSError, match="there is no directory"):
        model.save(tmp_path / "none" / "m.model")
    with pytest.raises(FileNotFoundError, match="cannot read"):
        Model.load(tmp_path / "none.model")
    with pytest.raises(ValueError, match="got text, expected a model file"):
        Model.load(tmp_path / "scene.toml")
    with pytest.raises(ValueError, match="model in memory: "):
        Model.from_bytes(model.to_bytes()[:-1])


def test_support_vectors_are_configurations_of_both_sides(model: Model, planar: Scene) -> None:
    support = model.support_vectors
    assert support.dtype == np.float64 and support.shape[1] == 3 and support.flags.c_contiguous
    assert 0 < len(support) <= model.statistics["support_vectors"] and len(np.unique(support, axis=0)) == len(support)
    free = planar.check(support)
    assert 0.1 < free.mean() < 0.9
    # Support vectors lie near the boundary: colliding ones are nearer to free space than random configurations.
    anywhere = planar.sample(2000, seed=5, colliding=True)
    colliding = support[~free]
    assert np.median(model.query_batch(colliding)["depth"]) < np.median(model.query_batch(anywhere)["depth"])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(model)).support_vectors, support)


def test_threads_share_a_model(model: Model, planar: Scene) -> None:
    Q = planar.sample(400, seed=6, colliding=True)
    expected = [model.query(q).depth for q in Q]
    found = [[0.0] * len(Q) for _ in range(4)]

    def ask(mine: list) -> None:  # type: ignore[type-arg]
        for k, q in enumerate(Q):
            mine[k] = model.query(q).depth

    threads = [threading.Thread(target=ask, args=(mine,)) for mine in found]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(mine == expected for mine in found)


def test_the_interpreter_goes_on_during_a_call(arm: Scene) -> None:
    ticks = []
    done = threading.Event()

    def tick() -> None:
        while not done.wait(0.01):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    model = extricate.learn(arm, labels=100_000_000, seconds=1.5, threads=1)
    done.set()
    thread.join()
    assert model.statistics["ended_by"] == "seconds"
    # If the lock were not released, there would be one tick or two.
    assert len(ticks) > 15


def test_a_wrong_row_is_told_before_anything_is_asked(model: Model, planar: Scene) -> None:
    Q = planar.sample(200_000, seed=2)
    Q[-1, 1] = np.nan
    started = time.monotonic()
    with pytest.raises(ValueError, match=r"Q\[199999\]: .*got NaN"):
        model.query_batch(Q, effort="exhaustive")
    assert time.monotonic() - started < 5


LONG = {
    "learn": lambda scene, model, Q: extricate.learn(scene, labels=10**9),
    "check": lambda scene, model, Q: [scene.check(Q) for _ in range(1000)],
    "query_batch": lambda scene, model, Q: model.query_batch(Q, effort="exhaustive"),
    "check_segments": lambda scene, model, Q: [scene.check_segments(Q, Q[::-1]) for _ in range(1000)],
    "sample": lambda scene, model, Q: scene.sample(10**9),
    "always_colliding": lambda scene, model, Q: scene.always_colliding(10**9, share=0.01),
}


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
@pytest.mark.parametrize("name", LONG)
def test_an_interrupt_ends_a_long_call(name: str, planar: Scene, model: Model) -> None:
    Q = planar.sample(200_000, seed=1)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        LONG[name](planar, model, Q)
    assert time.monotonic() - started < 10
    assert model.query(Q[0]).verified


# A query of an arm of meshes from thousands of samples, with a limit of time as the last resort. The shortest, a frame of a stream,
# takes a quarter of a second on a fast machine.
SOON = 0.02
ENDLESS = {"effort": "exhaustive", "starts": 10**5, "max_seconds": 60}


@pytest.fixture(scope="module")
def of_meshes(arm: Scene) -> Model:
    return extricate.learn(arm, labels=400_000)


ONE = {
    "query": lambda model, q: model.query(q, exits=9, segment=True, **ENDLESS),
    "query in another scene": lambda model, q: model.in_scene(model.scene).query(q, **ENDLESS),
    "query_batch": lambda model, q: model.query_batch([q, q], **ENDLESS),
    "a frame of a stream": lambda model, q: model.stream(**ENDLESS).query(q),
}


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
@pytest.mark.parametrize("name", ONE)
def test_an_interrupt_ends_one_query(name: str, of_meshes: Model) -> None:
    q = of_meshes.scene.sample(1, seed=1, colliding=True)[0]
    threading.Timer(SOON, os.kill, (os.getpid(), signal.SIGINT)).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        ONE[name](of_meshes, q)
    assert time.monotonic() - started < 3  # The query may take 60 s.
    assert of_meshes.query(q).verified


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
def test_signal_handlers_run_during_a_query_and_may_ask(of_meshes: Model) -> None:
    model, long = of_meshes, {**ENDLESS, "max_seconds": 1.0}
    q = model.scene.sample(1, seed=1, colliding=True)[0]
    stream = model.stream(**long)
    heard, refused = [], []

    def handler(number: int, frame: object) -> None:
        heard.append(model.query(q).depth)
        try:
            stream.query(q)
        except RuntimeError as error:
            refused.append(str(error))

    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, SOON)
        model.query(q, **long)
        assert len(heard) == 1 and refused == []
        signal.setitimer(signal.ITIMER_REAL, SOON)
        answer = stream.query(q)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert len(heard) == 2 and refused == ["stream: got a call from a signal handler, during a call of its own"]
    assert answer.verified and answer.depth <= heard[0] == heard[1]


def ask_in_child(model: Model, scene: Scene, Q: np.ndarray, answers) -> None:  # type: ignore[no-untyped-def, type-arg]
    learned = extricate.learn(scene, labels=2000).statistics["labels"]
    again = pickle.loads(pickle.dumps(model))
    answers.put((again.query_batch(Q)["depth"].tolist(), scene.check(Q).tolist(), learned))


@pytest.mark.parametrize("method", sorted({"fork", "spawn"}.intersection(multiprocessing.get_all_start_methods())))
def test_children_of_a_process_can_ask(method: str, model: Model, planar: Scene) -> None:
    Q = planar.sample(100, seed=7)
    expected = model.query_batch(Q)["depth"].tolist()
    context = multiprocessing.get_context(method)
    answers = context.Queue()
    child = context.Process(target=ask_in_child, args=(model, planar, Q, answers))
    child.start()
    depths, free, learned = answers.get(timeout=120)
    child.join(timeout=60)
    assert child.exitcode == 0 and depths == expected and free == planar.check(Q).tolist() and learned > 1000


# Calls that read or prepare geometry on threads, after a fork. They run in a process of their own, which can be killed if it hangs.
FORK = """
import os, pickle, signal, sys, tempfile
import numpy as np
import extricate
from extricate import Box, Mesh, Model, Scene

signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
urdf = Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()

def cubes(size):
    return [Mesh((size * (1 + k / 8) * signs, faces), [1, k - 1, 0.02 * k], name=f"cube{k}") for k in range(3)]

def ask(size):
    scene = Scene(urdf, cubes(size))
    q = scene.sample(1, seed=1, colliding=True)[0]
    assert not scene.check(q)
    model = extricate.learn(scene, labels=500)
    with tempfile.TemporaryDirectory() as folder:
        model.save(folder + "/a.model")
        Model.load(folder + "/a.model").query(q)
    copy = pickle.loads(pickle.dumps(model))
    for made in (scene, pickle.loads(pickle.dumps(scene)), scene.moved({"cube0": [1.1, 0, 0]}), Scene.builtin("hand"),
                 Scene(urdf).with_obstacles(cubes(size)), scene.without(["cube2"]), copy.in_scene(scene.without(["cube0"])), copy):
        of = made if isinstance(made, Scene) else made.scene
        q = of.sample(1, seed=1, colliding=True)[0]
        assert of.check(q) == False and made.query(q).verified
        assert len((made.batch if isinstance(made, extricate.Solver) else made.query_batch)([q, q])) == 2
        assert made.query(q, weights={of.joints[0].name: 2.0}).verified
    scene = scene.moved({"cube0": [1.2, 0, 0]})
    scene.always_colliding(10), scene.distances(scene.sample(200)), scene.colliding_pairs(scene.sample(1)[0])
    other = scene.moved({"cube0": [1.3, 0, 0]})
    other.escape(other.sample(1, seed=1, colliding=True)[0], tree_checks=100)
    scene.moved({"cube0": [1.4, 0, 0]}).check_segments(scene.sample(3), scene.sample(3, seed=1))
    scene.moved({"cube0": [1.5, 0, 0]}).robot_filter([[0, 0, 0]], scene.sample(1)[0])
    scene.moved({"cube0": [1.6, 0, 0]}).release(scene.sample(2), object="cube1", max_checks=50)
    scene.attach(Mesh((0.01 * signs, faces), name="held"), link=scene.bodies[0]).check(scene.sample(1)[0])
    extricate.learn(scene, labels=200)

ask(0.1)
child = os.fork()
if child == 0:
    # The child of a fault has to end too.
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(60)
    try:
        ask(0.11)
    except BaseException:
        import traceback
        traceback.print_exc()
        os._exit(1)
    os._exit(0)
status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
sys.exit(f"the child ended with {status}" if status else 0)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs POSIX")
def test_a_child_can_make_and_ask_what_its_parent_did() -> None:
    done = subprocess.run([sys.executable, "-c", FORK], capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stderr


def test_wrong_questions_are_told_what_was_expected(model: Model, planar: Scene) -> None:
    for call, message in [
        (lambda: model.query([0, 0]), r"q: got shape \(2,\), expected \(3,\): the scene has 3"),
        (lambda: model.query(np.zeros((1, 3))), r"q: got shape \(1, 3\), expected \(3,\)"),
        (lambda: model.query([0, 0, np.nan]), "got NaN, expected a finite number"),
        (lambda: planar.distances([[0, 0, 50]]), "got 50, expected a value within"),
        (lambda: model.query([0, 0, 0], effort="best"), 'effort: got "best", expected "nearest", "quick", "refined"'),
        (lambda: model.query([0, 0, 0], exits=0), "exits: got 0, expected 1 to 100000"),
        (lambda: model.query([0, 0, 0], exits=2, effort="nearest"), 'exits: got 2, expected 1 with effort "nearest"'),
        (lambda: model.query([0, 0, 0], max_checks=-1), "max_checks: got -1, expected 0 or more"),
        (lambda: model.query([0, 0, 0], starts=0), "starts: got 0, expected 1 to 100000"),
        (lambda: model.query([0, 0, 0], starts=4, effort="nearest"), 'starts: got 4, expected none with effort "nearest"'),
        (lambda: model.query_batch(np.zeros((1, 3)), starts=4, effort="nearest"), 'starts: got 4, expected none with effort "nearest"'),
        (lambda: model.in_scene(model.scene).query([0, 0, 0], starts=4, effort="nearest"), 'starts: got 4, expected none with effort "nearest"'),
        (lambda: model.stream(starts=4, effort="nearest"), 'starts: got 4, expected none with effort "nearest"'),
        (lambda: model.query([0, 0, 0], max_seconds=float("nan")), "max_seconds: got NaN, expected more than 0"),
        (lambda: model.stream(hysteresis=1), "hysteresis: got 1, expected 0 or more and less than 1"),
        (lambda: model.stream().query([0, 0]), r"q: got shape \(2,\)"),
        (lambda: model.query_batch(np.zeros((3, 2))), r"Q: got shape \(3, 2\)"),
        (lambda: model.query_batch([[0, 0, 0]] * 99 + [[0, np.inf, 0]]), r"Q\[99\]: .*got inf, expected a finite"),
        (lambda: model.query_batch(np.zeros((3, 3)), threads=-2), "threads: got -2"),
        (lambda: extricate.learn(planar, labels=0), "labels: got 0, expected at least 1"),
        (lambda: extricate.learn(planar, seconds=-1), "seconds: got -1, expected more than 0"),
        (lambda: extricate.learn(planar, seconds=float("nan")), "seconds: got NaN"),
        (lambda: extricate.learn(planar, threads=-1), "threads: got -1"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()


def test_a_scene_without_a_free_configuration_is_told() -> None:
    from test_scene import SLIDER

    with pytest.raises(RuntimeError, match=r"no collision-free configuration among .* these pairs collide every time"):
        extricate.learn(Scene(SLIDER, [extricate.Box([99, 1, 1])]), labels=5000)
