"""The example that measures self-touch as BabyBench does, on Max."""

import importlib.util
import sys
from types import SimpleNamespace
from typing import Any

import bodyschema as bs
import numpy as np
import pytest
from conftest import REPOSITORY

pytest.importorskip("gymnasium")
STEPS = 300


@pytest.fixture(scope="module")
def example() -> Any:
    path = REPOSITORY / "python" / "examples" / "babybench.py"
    spec = importlib.util.spec_from_file_location("babybench", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Its dataclasses look their module up.
    sys.modules["babybench"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def env() -> Any:
    from bodyschema.environment import SelfTouch

    return SelfTouch(frame_skip=25)


@pytest.fixture
def policy(example: Any, env: Any, creature: bs.Creature, schema: bs.Schema, session: bs.Session) -> Any:
    made = example.Recall(creature, schema, env.action_time, env.start)
    made.babbled(session)
    made.settle()
    return made


def test_a_touch_of_a_hand_is_counted_by_geom(example: Any, creature: bs.Creature) -> None:
    limbs, geoms = creature.receptors["limb"], creature.receptors["geom"]
    first = {limb: int(np.flatnonzero(limbs == limb)[0]) for limb in creature.limbs if limb in limbs}
    left, right, head = first["left_hand"], first["right_hand"], first["head"]
    neither = next(receptor for limb, receptor in first.items() if limb not in ("left_hand", "right_hand", "head"))
    found = example.touched(creature, [[head, left], [left, right], [head, neither]])
    assert found == {("left_hand", geoms[head]), ("left_hand", geoms[right]), ("right_hand", geoms[left])}
    assert example.touched(creature, np.zeros((0, 2), int)) == set()


def test_recalling_touches_and_resting_does_not(example: Any, env: Any, policy: Any) -> None:
    found = example.episode(env, policy, 1, STEPS)
    assert found == policy.felt and found <= set(policy.joints)
    assert len(found) >= 8

    class Still:
        rest, hands = env.start, example.HANDS
        begin = staticmethod(lambda: None)
        feel = staticmethod(lambda posture, touches: None)
        act = staticmethod(lambda posture: env.start)

    assert example.episode(env, Still(), 1, STEPS) == set()


def test_practice_is_remembered(example: Any, env: Any, policy: Any) -> None:
    before = {pair: len(memory.postures) for pair, memory in policy.memory.items()}
    found = example.episode(env, policy, 2, STEPS)
    for pair in found:
        memory = policy.memory[pair]
        assert len(memory.postures) == before.get(pair, 0) + 1
        assert memory.felt[-1] >= 1 and (memory.felt <= memory.tried).all()
    assert sum(memory.tried.sum() for memory in policy.memory.values()) > len(found)


def test_it_plugs_into_the_starter_kit(example: Any, env: Any, policy: Any, creature: bs.Creature) -> None:
    names = creature.coordinates[::-1]
    actuated = creature.coordinates[5:20]
    model = SimpleNamespace(
        actuator_trnid=np.array([[names.index(name), -1] for name in actuated]),
        joint=lambda number: SimpleNamespace(name=names[number]),
    )
    kit = SimpleNamespace(proprioception=SimpleNamespace(joint_names=names), model=model)
    act = example.StarterKit(SimpleNamespace(unwrapped=kit), policy)
    posture = env.start + 0.01 * np.arange(len(names))
    pair = next(iter(policy.memory))
    info = {f"{pair[0]}_touches": [pair[1]]}
    action = act({"observation": np.append(posture[::-1], np.zeros(7))}, info)
    assert policy.felt == {pair} and action.shape == (len(actuated),)
    moved = action - posture[5:20]
    assert 0 < np.abs(moved).max() <= example.SPEED * env.action_time + 1e-6
