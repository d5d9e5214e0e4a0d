"""Wrong uses: each is an exception with a sentence, never a crash."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bodyschema as bs
import numpy as np
import pytest
from conftest import BODIES, MAX, REPOSITORY, ROBOT

NAN, INF = float("nan"), float("inf")
Call = Callable[[Any], object]


class Given:
    """What wrong uses are made of."""

    def __init__(self, creature: bs.Creature, session: bs.Session, schema: bs.Schema, folder: Path) -> None:
        self.creature, self.session, self.schema, self.folder = creature, session, schema, folder
        self.robot = bs.Robot(ROBOT / "arms.urdf")
        self.q = creature.sample_postures(5)
        self.log = ROBOT / "touches.csv"

    def file(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.write_text(text)
        return path


@pytest.fixture(scope="module")
def given(creature: bs.Creature, session: bs.Session, schema: bs.Schema, tmp_path_factory: pytest.TempPathFactory) -> Given:
    return Given(creature, session, schema, tmp_path_factory.mktemp("wrong"))


def q(change: Callable[[Any], Any]) -> list[tuple[str, Call]]:
    """Wrong postures, given to all that takes some."""
    return [
        ("pose", lambda g: g.schema.pose("head", change(g.q))),
        ("jacobian", lambda g: g.schema.jacobian("head", change(g.q))),
        ("position_std", lambda g: g.schema.position_std("head", change(g.q))),
    ]


POSTURES: dict[str, Callable[[Any], Any]] = {
    "few columns": lambda q: q[:, :5],
    "many columns": lambda q: np.hstack([q, q]),
    "too deep": lambda q: q[None],
    "a number": lambda q: 1.0,
    "empty": lambda q: [],
    "nan": lambda q: np.where(np.arange(q.size).reshape(q.shape) == 7, NAN, q),
    "infinite": lambda q: q * INF,
    "words": lambda q: "left_hand",
    "ragged": lambda q: [[1.0], [2.0, 3.0]],
    "nothing": lambda q: None,
    "a dictionary": lambda q: {"a": 1},
    "objects": lambda q: np.array([object()] * q.shape[1]),
    "an object": lambda q: object(),
    "no rows and wrong": lambda q: np.zeros((0, 3)),
}

VALUE: dict[str, Call] = {
    **{f"{name} of {what}": call for what, change in POSTURES.items() for name, call in q(change)},
    "limb": lambda g: g.schema.pose("nobody", g.q),
    "limb of several": lambda g: g.schema.pose(["head", "nobody"], g.q),
    "limb empty": lambda g: g.schema.pose("", g.q),
    "limb zero byte": lambda g: g.schema.pose("a\0b", g.q),
    "wrt": lambda g: g.schema.pose("head", g.q, wrt="nobody"),
    "jacobian limb": lambda g: g.schema.jacobian("nobody", g.q),
    "jacobian wrt": lambda g: g.schema.jacobian("head", g.q, wrt="nobody"),
    "std limb": lambda g: g.schema.position_std("nobody", g.q),
    "std point short": lambda g: g.schema.position_std("head", g.q, point=[1, 2]),
    "std point nan": lambda g: g.schema.position_std("head", g.q, point=[1, 2, NAN]),
    "std point words": lambda g: g.schema.position_std("head", g.q, point="abc"),
    "reach limb": lambda g: g.schema.reach("nobody", [0, 0, 0]),
    "reach short": lambda g: g.schema.reach("head", [0, 0]),
    "reach nan": lambda g: g.schema.reach("head", [0, 0, NAN]),
    "reach deep": lambda g: g.schema.reach("head", [[0, 0, 0]]),
    "reach none": lambda g: g.schema.reach("head", None),
    "reachable limb": lambda g: g.schema.reachable("nobody"),
    "voxel zero": lambda g: g.schema.reachable("head", 0.0),
    "voxel negative": lambda g: g.schema.reachable("head", -0.1),
    "voxel nan": lambda g: g.schema.reachable("head", NAN),
    "voxel infinite": lambda g: g.schema.reachable("head", INF),
    "voxel tiny": lambda g: g.schema.reachable("head", 1e-9),
    "save ending": lambda g: g.schema.save(g.folder / "a.doc"),
    "save without ending": lambda g: g.schema.save(g.folder / "a"),
    "too many postures": lambda g: g.creature.sample_postures(2**40),
    "model a folder": lambda g: bs.Creature(g.folder),
    "touches zero": lambda g: bs.babble(g.creature, touches=0),
    "jobs zero": lambda g: bs.babble(g.creature, jobs=0),
    "seconds zero": lambda g: bs.babble(g.creature, seconds=0.0),
    "seconds negative": lambda g: bs.babble(g.creature, seconds=-1.0),
    "seconds nan": lambda g: bs.babble(g.creature, seconds=NAN),
    "work infinite": lambda g: bs.babble(g.creature, work=INF),
    "seconds and work": lambda g: bs.babble(g.creature, seconds=1.0, work=1.0),
    "policy": lambda g: bs.babble(g.creature, policy="by chance"),
    "motion": lambda g: bs.babble(g.creature, motion="fast"),
    "babble learner": lambda g: bs.babble(g.creature, learner="nobody"),
    "learner": lambda g: bs.learn(g.session, learner="nobody"),
    "learner a number": lambda g: bs.learn(g.session, learner=3),
    "input": lambda g: bs.learn(g.session, input="smell"),
    "skin": lambda g: bs.learn(g.session, skin="fur"),
    "frames": lambda g: bs.learn(g.session, frames="picture"),
    "frames by receptors": lambda g: bs.learn(g.session, learner="lm", frames="limb"),
    "noise negative": lambda g: bs.learn(g.session, joint_noise_deg=-1.0),
    "noise nan": lambda g: bs.learn(g.session, receptor_noise_mm=NAN),
    "noise words": lambda g: bs.learn(g.session, point_noise_mm="much"),
    "false touches one": lambda g: bs.learn(g.session, false_touches=1.0),
    "known a number": lambda g: bs.learn(g.session, known=3),
    "growth by centres": lambda g: bs.learn(g.session, learner="growth", skin="centres"),
    "record one posture": lambda g: bs.record(g.creature, g.q[0], [[0, 300]]),
    "record other counts": lambda g: bs.record(g.creature, g.q, [[0, 300]]),
    "record flat": lambda g: bs.record(g.creature, g.q, [0, 1, 2, 3, 4]),
    "record no receptor": lambda g: bs.record(g.creature, g.q[:1], [[0, 100000]]),
    "record negative receptor": lambda g: bs.record(g.creature, g.q[:1], [[-1, 3]]),
    "record part of a receptor": lambda g: bs.record(g.creature, g.q[:1], [[0.5, 3]]),
    "record one limb": lambda g: bs.record(g.creature, g.q[:1], [[0, 0]]),
    "record words": lambda g: bs.record(g.creature, g.q[:1], [["a", "b"]]),
    "record points flat": lambda g: bs.record(g.creature, g.q[:1], [[0, 300]], [1, 2, 3]),
    "record points nan": lambda g: bs.record(g.creature, g.q[:1], [[0, 300]], [[[0, 0, NAN], [0, 0, 0]]]),
    "record points far": lambda g: bs.record(g.creature, g.q[:1], [[0, 300]], [[[0, 0, 900.0], [0, 0, 0]]]),
    "record posture far": lambda g: bs.record(g.creature, g.q[:1] + 100, [[0, 300]]),
    "evaluate another": lambda g: bs.evaluate(g.schema, bs.Creature(BODIES / "ant.xml")),
    "session there": lambda g: g.session.save(g.folder / "twice") or g.session.save(g.folder / "twice"),
    "free": lambda g: bs.calibrate(g.robot, g.log, free=["nobody.offset"]),
    "free a number": lambda g: bs.calibrate(g.robot, g.log, free=3),
    "fix": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", fix="nobody"),
    "prior": lambda g: bs.calibrate(g.robot, g.log, prior={"nobody": 1.0}),
    "prior zero": lambda g: bs.calibrate(g.robot, g.log, prior={"*.offset": 0.0}),
    "prior nan": lambda g: bs.calibrate(g.robot, g.log, prior={"*.offset": NAN}),
    "nothing free": lambda g: bs.calibrate(g.robot, g.log, free=[]),
    "all fixed": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", fix="*"),
    "held out all": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", held_out=1.0),
    "held out nothing": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", held_out=0.0),
    "held out nan": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", held_out=NAN),
    "held out a list": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", held_out=[1]),
    "folds one": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", folds=1),
    "folds and held out": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", folds=3, held_out=0.3),
    "joint noise": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", joint_noise=-1.0),
    "study": lambda g: bs.study("nobody", seeds=range(2)),
    "study no seeds": lambda g: bs.study("bodies", seeds=range(0)),
    "study other seeds": lambda g: bs.study("bodies", seeds=[1, 3]),
    "study seeds words": lambda g: bs.study("bodies", seeds="abc"),
    "study seeds a number": lambda g: bs.study("bodies", seeds=3),
    "study negative seeds": lambda g: bs.study("bodies", seeds=range(-2, 0)),
    "study case": lambda g: bs.study("bodies", seeds=range(1), cases=["nobody"]),
    "study work": lambda g: bs.study("bodies", seeds=range(1), work=0.0),
    "study touches": lambda g: bs.study("calibration", seeds=range(1), touches=5),
    "study of a creature": lambda g: bs.study("bodies", seeds=range(1), creature=g.creature),
    "study of nobody": lambda g: bs.study("learners", seeds=range(1)),
}

MISSING: dict[str, Call] = {
    "creature": lambda g: bs.Creature("no/such.xml"),
    "creature without a name": lambda g: bs.Creature(""),
    "robot": lambda g: bs.Robot("no/such.urdf"),
    "log": lambda g: bs.calibrate(g.robot, "no/such.csv", free="*.offset"),
    "held-out log": lambda g: bs.calibrate(g.robot, g.log, free="*.offset", held_out="no/such.csv"),
    "session": lambda g: bs.open("no/such"),
    "session without a file": lambda g: bs.open(g.folder / "nothing"),
    "known": lambda g: bs.learn(g.session, learner="lm", known="no/such.json"),
    "save": lambda g: g.schema.save("no/such/a.xml"),
    "save json": lambda g: g.schema.save("no/such/a.json"),
}

ERROR: dict[str, Call] = {
    "empty model": lambda g: bs.Creature(g.file("empty.xml", "")),
    "no model": lambda g: bs.Creature(g.file("words.xml", "What is this?")),
    "broken model": lambda g: bs.Creature(g.file("broken.xml", "<mujoco><worldbody>")),
    "stiff model": lambda g: bs.Creature(g.file("stiff.xml", "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")),
    "joints": lambda g: bs.Creature("max", joints="nobody"),
    "root": lambda g: bs.Creature("max", root="nobody"),
    "a log as a robot": lambda g: bs.Robot(g.log),
    "a robot as a log": lambda g: bs.calibrate(g.robot, ROBOT / "arms.urdf", free="*.offset"),
    "an empty log": lambda g: bs.calibrate(g.robot, g.file("empty.csv", ""), free="*.offset"),
    "an empty robot": lambda g: bs.Robot(g.file("empty.urdf", "")),
    "known is none": lambda g: bs.learn(g.session, learner="lm", known=g.file("known.json", "{")),
    "a folder as a session": lambda g: bs.open(REPOSITORY / "mjcf"),
    "a file as a session": lambda g: bs.open(MAX),
}

TYPE: dict[str, Call] = {
    "creature none": lambda g: bs.Creature(None),
    "creature twice": lambda g: bs.Creature("max", "max"),
    "creature option": lambda g: bs.Creature("max", bones="all"),
    "babble a name": lambda g: bs.babble("max"),
    "babble option": lambda g: bs.babble(g.creature, hands=2),
    "babble touches words": lambda g: bs.babble(g.creature, touches="many"),
    "babble touches half": lambda g: bs.babble(g.creature, touches=1.5),
    "babble seed words": lambda g: bs.babble(g.creature, seed="one"),
    "learn a creature": lambda g: bs.learn(g.creature),
    "learn option": lambda g: bs.learn(g.session, speed="fast"),
    "evaluate nothing": lambda g: bs.evaluate(None, g.creature),
    "pose without postures": lambda g: g.schema.pose("head"),
    "pose of a number": lambda g: g.schema.pose(3, g.q),
    "pose of numbers": lambda g: g.schema.pose([1, 2], g.q),
    "calibrate a path": lambda g: bs.calibrate("arms.urdf", g.log),
    "prior a list": lambda g: bs.calibrate(g.robot, g.log, prior=["*.offset"]),
    "study creature": lambda g: bs.study("learners", seeds=range(1), creature="max"),
    "a schema of nothing": lambda g: bs.Schema(),
    "a session of nothing": lambda g: bs.Session(),
    "postures of words": lambda g: g.creature.sample_postures("many"),
}

RANGE: dict[str, Call] = {
    "touches negative": lambda g: bs.babble(g.creature, touches=-1),
    "seed negative": lambda g: bs.babble(g.creature, seed=-1),
    "seed huge": lambda g: bs.babble(g.creature, seed=2**64),
    "postures negative": lambda g: g.creature.sample_postures(-1),
    "jobs huge": lambda g: bs.babble(g.creature, jobs=10**6),
}

# Each of many functions with each of many wrong values.
LIMB_OF: dict[str, Callable[[Any, Any], object]] = {
    "pose": lambda g, limb: g.schema.pose(limb, g.q),
    "pose of several": lambda g, limb: g.schema.pose(["head", limb], g.q),
    "pose wrt": lambda g, limb: g.schema.pose("head", g.q, wrt=limb),
    "jacobian": lambda g, limb: g.schema.jacobian(limb, g.q),
    "jacobian wrt": lambda g, limb: g.schema.jacobian("head", g.q, wrt=limb),
    "position_std": lambda g, limb: g.schema.position_std(limb, g.q),
    "reach": lambda g, limb: g.schema.reach(limb, [0.1, 0.1, 0.1]),
    "reachable": lambda g, limb: g.schema.reachable(limb),
}
NO_LIMBS = ["nobody", "", "a\0b", " head", "HEAD", "head\n", "é", "../head", "0", "x" * 10_000]

CHOICE_OF: dict[str, Callable[[Any, Any], object]] = {
    **{
        f"{name} {option}": lambda g, word, name=name, option=option: (
            bs.learn(g.session, **{option: word}) if name == "learn" else bs.babble(g.creature, touches=3, **{option: word})
        )
        for name in ("learn", "babble")
        for option in ("learner", "input", "skin", "frames")
    },
    "policy": lambda g, word: bs.babble(g.creature, policy=word),
    "motion": lambda g, word: bs.babble(g.creature, motion=word),
    "study": lambda g, word: bs.study(word, seeds=range(1)),
    "study case": lambda g, word: bs.study("bodies", seeds=range(1), cases=[word or "nobody"]),
}
NO_CHOICES = ["nobody", "", "LM", " lm", "a\0b", "é", "x" * 10_000]

POSITIVE: dict[str, Callable[[Any, Any], object]] = {
    "voxel": lambda g, x: g.schema.reachable("head", x),
    "seconds": lambda g, x: bs.babble(g.creature, seconds=x),
    "work": lambda g, x: bs.babble(g.creature, work=x),
    "study work": lambda g, x: bs.study("bodies", seeds=range(1), work=x),
    "prior": lambda g, x: bs.calibrate(g.robot, g.log, prior={"*.offset": x}),
}
NOT_NEGATIVE: dict[str, Callable[[Any, Any], object]] = {
    **{
        option: lambda g, x, option=option: bs.learn(g.session, **{option: x})
        for option in ("joint_noise_deg", "receptor_noise_mm", "point_noise_mm", "false_touches")
    },
    "calibrate joint_noise": lambda g, x: bs.calibrate(g.robot, g.log, free="*.offset", joint_noise=x),
}

POINT_OF: dict[str, Callable[[Any, Any], object]] = {
    "reach": lambda g, point: g.schema.reach("head", point),
    "position_std": lambda g, point: g.schema.position_std("head", g.q, point=point),
}
NO_POINTS: dict[str, Any] = {
    "a number": 1.0,
    "empty": [],
    "two": [1, 2],
    "four": [1, 2, 3, 4],
    "deep": [[0, 0, 0]],
    "nan": [0, NAN, 0],
    "infinite": [0, 0, -INF],
    "words": ["a", "b", "c"],
    "nothing in it": [None, None, None],
    "a dictionary": {"x": 1},
    "an object": object(),
    "ragged": [[1], [2, 3]],
}

OTHER_KINDS: dict[str, Any] = {
    "none": None,
    "a number": 3,
    "words": "max",
    "a list": [],
    "a dictionary": {},
    "an object": object(),
}
OF_KIND: dict[str, Callable[[Any, Any], object]] = {
    "babble": lambda g, it: bs.babble(it, touches=3),
    "learn": lambda g, it: bs.learn(it),
    "evaluate a schema": lambda g, it: bs.evaluate(it, g.creature),
    "evaluate a creature": lambda g, it: bs.evaluate(g.schema, it),
    "record": lambda g, it: bs.record(it, g.q, [[0, 300]] * 5),
    "calibrate": lambda g, it: bs.calibrate(it, g.log, free="*.offset"),
}
PATH_OF: dict[str, Callable[[Any, Any], object]] = {
    "creature": lambda g, path: bs.Creature(path),
    "robot": lambda g, path: bs.Robot(path),
    "open": lambda g, path: bs.open(path),
    "save": lambda g, path: g.schema.save(path),
    "session save": lambda g, path: g.session.save(path),
}
NO_PATHS: dict[str, Any] = {"none": None, "a number": 3, "half": 0.5, "a list": [], "an object": object()}
NO_FILES = ["no/such", "/proc/nobody/no", "no such", "\u00e9/\u00e9"]

WHOLE_OF: dict[str, Callable[[Any, Any], object]] = {
    "touches": lambda g, n: bs.babble(g.creature, touches=n),
    "seed": lambda g, n: bs.babble(g.creature, touches=3, seed=n),
    "jobs": lambda g, n: bs.babble(g.creature, touches=3, jobs=n),
    "postures": lambda g, n: g.creature.sample_postures(n),
    "learn touches": lambda g, n: bs.learn(g.session, touches=n),
    "folds": lambda g, n: bs.calibrate(g.robot, g.log, free="*.offset", folds=n),
    "study touches": lambda g, n: bs.study("learners", seeds=range(1), creature=g.creature, touches=n),
}

CONTENTS = {
    "empty": "",
    "a brace": "{",
    "a bracket": "<",
    "words": "What is this?",
    "a page": "<html><body>no</body></html>",
    "zeros": "\0" * 100,
    "deep": "[" * 10_000,
    "deep elements": "<a>" * 10_000,
    "a table": "a,b,c\n1,2\n",
    "json of another kind": '{"creature": 3, "touches": "many"}',
}
READER_OF: dict[str, Callable[[Any, Any], object]] = {
    "creature": lambda g, path: bs.Creature(path),
    "robot": lambda g, path: bs.Robot(path),
    "log": lambda g, path: bs.calibrate(g.robot, path, free="*.offset"),
    "held-out log": lambda g, path: bs.calibrate(g.robot, g.log, free="*.offset", held_out=path),
    "known": lambda g, path: bs.learn(g.session, learner="lm", known=path),
}


def each(kind: type[Exception], calls: dict[str, Callable[[Any, Any], object]], values: Any) -> list[Any]:
    """Each function with each wrong value."""
    values = values.items() if isinstance(values, dict) else [(repr(value)[:20], value) for value in values]
    return [
        pytest.param(kind, lambda g, call=call, value=value: call(g, value), id=f"{kind.__name__}: {name}, {what}")
        for name, call in calls.items()
        for what, value in values
    ]


def without(calls: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: call for name, call in calls.items() if name not in names}


def of_content(call: Callable[[Any, Any], object]) -> Callable[[Any, Any], object]:
    return lambda g, content: call(g, g.file(f"content-{abs(hash(content))}", content))


ALL = [
    *[
        pytest.param(kind, call, id=f"{kind.__name__}: {name}")
        for kind, calls in [
            (ValueError, VALUE),
            (FileNotFoundError, MISSING),
            (bs.Error, ERROR),
            (TypeError, TYPE),
            (OverflowError, RANGE),
        ]
        for name, call in calls.items()
    ],
    *each(ValueError, LIMB_OF, NO_LIMBS),
    *each(ValueError, CHOICE_OF, NO_CHOICES),
    *each(ValueError, POSITIVE, [0.0, -1.0, NAN, INF, -INF]),
    *each(ValueError, NOT_NEGATIVE, [-1.0, NAN, INF, -INF, -1e-300]),
    *each(ValueError, POINT_OF, NO_POINTS),
    *each(TypeError, OF_KIND, OTHER_KINDS),
    *each(TypeError, PATH_OF, NO_PATHS),
    *each(FileNotFoundError, without(PATH_OF, "save", "session save"), NO_FILES),
    *each(OverflowError, WHOLE_OF, [-1, 2**64, -(2**64), 2**200]),
    *each(TypeError, WHOLE_OF, ["many", 1.5, [1], {}]),
    *each(bs.Error, {name: of_content(call) for name, call in READER_OF.items()}, CONTENTS),
]


@pytest.mark.parametrize(("kind", "call"), ALL)
def test_a_wrong_use_is_an_exception_with_a_sentence(given: Given, kind: type[Exception], call: Call) -> None:
    with pytest.raises(kind) as raised:
        call(given)
    assert type(raised.value) is kind
    assert len(str(raised.value)) > 10


def test_there_are_many_wrong_uses() -> None:
    assert len(ALL) >= 500


def test_sentences_are_those_of_the_program() -> None:
    with pytest.raises(FileNotFoundError) as raised:
        bs.Creature("no/such.xml")
    assert str(raised.value) == "no/such.xml: no such file; give the path of an MJCF or URDF file"


def test_a_model_on_which_the_engine_crashes_is_refused(given: Given) -> None:
    given.file("text.obj", "v a b c\nv 1 2\n")
    model = """<mujoco><asset><mesh name="m" file="text.obj"/></asset><worldbody>
    <body><joint/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"""
    path = given.file("crash.xml", model)
    if int(bs.mujoco_version().split(".")[0]) > 2:
        # Newer engines refuse the mesh alone.
        with pytest.warns(UserWarning, match=r"crash\.xml was read without geom of the mesh m"):
            bs.Creature(path)
    else:
        with pytest.raises(bs.Error, match=r"crash\.xml"):
            bs.Creature(path)


def test_attributes_cannot_be_set(given: Given) -> None:
    with pytest.raises(AttributeError):
        given.schema.verdict = "Learned."  # type: ignore[misc]
    with pytest.raises(AttributeError, match="there is no mode: choose one of"):
        _ = bs.evaluate(given.schema, given.creature).determined_mm.mode
