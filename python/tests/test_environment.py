"""Environments of Gymnasium."""

import threading
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import bodyschema as bs
import numpy as np
import pytest
from conftest import BODIES

gym = pytest.importorskip("gymnasium")

from bodyschema.environment import SelfTouch, SelfTouchVector  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

ID, D = "bodyschema/Max-v0", 42


@pytest.fixture(scope="module")
def env() -> Iterator[Any]:
    made = gym.make(ID)
    yield made
    made.close()


@pytest.fixture(scope="module")
def three() -> Iterator[Any]:
    made = gym.make_vec(ID, num_envs=3, max_episode_steps=20)
    yield made
    made.close()


@pytest.mark.parametrize("model", [None, "ant.xml", "crane.xml"])
def test_gymnasium_checks_it(model: str | None) -> None:
    made = gym.make(ID, **({} if model is None else {"model": BODIES / model, "joints": "all"}))
    with warnings.catch_warnings():
        # That a posture has no bounds, and that targets are not from -1 to 1, is meant.
        warnings.filterwarnings("ignore", message=".*(infinity|normalized).*")
        check_env(made.unwrapped, skip_render_check=True)


def test_an_observation_is_posture_and_touch(env: Any, creature: bs.Creature) -> None:
    observation, info = env.reset(seed=1)
    assert (observation.dtype, observation.shape, info) == (np.float32, (D + len(creature.receptors["id"]),), {})
    assert not observation[D:].any()
    target = creature.sample_postures(1, seed=8)[0]
    for _ in range(300):
        observation, _, terminated, truncated, _ = env.step(target)
    assert not (terminated or truncated)
    # Gravity is borne, and only what limbs meet on the way keeps a joint from its target.
    assert np.median(np.abs(observation[:D] - target)) < 0.01


def test_limbs_that_press_on_each_other_feel_it(env: Any, creature: bs.Creature, session: bs.Session) -> None:
    limbs, felt = creature.receptors["limb"], 0
    start = env.unwrapped._crowd.start
    for posture, pair in list(zip(session.postures, session.receptors, strict=True))[:5]:
        env.reset(seed=1)
        touched, total = np.zeros(len(limbs), bool), 0.0
        for _ in range(200):
            # On where they would pass through each other.
            observation, reward, _, _, info = env.step(posture + 0.3 * (posture - start))
            touched |= observation[D:] > 0
            total += reward
            assert observation[D:].max() < 1000
            assert set(info["touches"].ravel()) == set(np.flatnonzero(observation[D:]))
            assert (limbs[info["touches"][:, 0]] != limbs[info["touches"][:, 1]]).all()
        assert total == touched.sum()
        felt += set(limbs[pair]) <= set(limbs[touched])
    assert felt >= 4


def test_a_seed_gives_the_same_alone_and_among_others(env: Any, three: Any) -> None:
    three.action_space.seed(5)
    actions = [three.action_space.sample() for _ in range(15)]
    first, _ = three.reset(seed=7)
    together = [first, *(three.step(action)[0] for action in actions)]
    again, _ = three.reset(seed=[7, 8, 9])
    assert np.array_equal(np.array(together), np.array([again, *(three.step(action)[0] for action in actions)]))
    for i in range(3):
        alone, _ = env.reset(seed=7 + i)
        steps = [alone, *(env.step(action[i])[0] for action in actions)]
        assert np.array_equal(np.array(steps), np.array(together)[:, i])
    assert not np.array_equal(together[0][0], together[0][1])


def test_touches_of_several_are_each_its_own(three: Any, session: bs.Session) -> None:
    posture = session.postures[0]
    three.reset(options={"posture": posture})
    start = three.unwrapped.start
    # The middle one lets go.
    actions, seen = [posture + 0.3 * (posture - start), start, posture + 0.3 * (posture - start)], 0
    for _ in range(20):
        observation, _, _, _, info = three.step(actions)
        assert info["_touches"].all() and len(info["touches"]) == 3
        for row, pairs in zip(observation[:, D:], info["touches"], strict=True):
            assert set(pairs.ravel()) == set(np.flatnonzero(row))
        seen += len(info["touches"][0])
    assert seen > 0 and len(info["touches"][1]) == 0
    *_, info = three.step(actions)
    assert [len(pairs) for pairs in info["touches"]] == [0, 0, 0], "an episode begins without touches"


def test_an_episode_ends_and_begins_anew_in_the_next_step(three: Any) -> None:
    three.reset(seed=1)
    action = three.action_space.sample()
    ends = [three.step(action)[3].all() for _ in range(20)]
    assert ends == [False] * 19 + [True]
    observation, reward, terminated, truncated, _ = three.step(action)
    assert not observation[:, D:].any() and not reward.any() and not terminated.any() and not truncated.any()
    assert np.abs(observation[:, :D] - three.unwrapped.start).max() < 0.2


def test_observations_are_kept_by_whoever_keeps_them(three: Any) -> None:
    first, _ = three.reset(seed=2)
    action = three.action_space.sample()
    second = three.step(action)[0]
    before = [first.copy(), second.copy()]
    third = three.step(action)[0]
    assert np.array_equal(first, before[0]) and np.array_equal(second, before[1])
    assert not np.array_equal(second, third)


def test_two_threads_step_the_same(three: Any) -> None:
    three.reset(seed=3)
    action = three.action_space.sample()
    faults: list[Exception] = []

    def run() -> None:
        try:
            for _ in range(50):
                assert np.isfinite(three.step(action)[0]).all()
        except Exception as fault:
            faults.append(fault)

    threads = [threading.Thread(target=run) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert faults == []


def test_it_steps_fast(creature: bs.Creature) -> None:
    envs = SelfTouchVector(16)
    envs.reset(seed=1)
    envs.action_space.seed(1)
    action, steps = envs.action_space.sample(), 100
    begun = time.perf_counter()
    for k in range(steps):
        if k % 20 == 0:
            action = envs.action_space.sample()
        envs.step(action)
    rate = steps * 16 / (time.perf_counter() - begun)
    print(f"{rate:.0f} steps a second of 10 ms, {rate * envs._crowd.skip:.0f} of the physics")
    # Far below what it does: MIMo does 141 to 367 of 10 ms.
    assert rate > 400


WRONG: dict[str, tuple[type[Exception], Callable[[Any, Any], object]]] = {
    "short action": (ValueError, lambda env, three: env.step(np.zeros(3))),
    "deep action": (ValueError, lambda env, three: env.step(np.zeros((1, D)))),
    "action of one": (ValueError, lambda env, three: three.step(np.zeros(D))),
    "action of two": (ValueError, lambda env, three: three.step(np.zeros((2, D)))),
    "nan": (ValueError, lambda env, three: env.step(np.full(D, np.nan))),
    "infinite": (ValueError, lambda env, three: env.step(np.full(D, np.inf))),
    "words": (ValueError, lambda env, three: env.step("left")),
    "nothing": (ValueError, lambda env, three: env.step(None)),
    "option": (ValueError, lambda env, three: env.reset(options={"pose": np.zeros(D)})),
    "short posture": (ValueError, lambda env, three: env.reset(options={"posture": np.zeros(3)})),
    "posture of nan": (ValueError, lambda env, three: three.reset(options={"posture": np.full(D, np.nan)})),
    "few seeds": (ValueError, lambda env, three: three.reset(seed=[1, 2])),
    "no environments": (ValueError, lambda env, three: SelfTouchVector(0)),
    "many environments": (ValueError, lambda env, three: SelfTouchVector(10**6)),
    "negative environments": (OverflowError, lambda env, three: SelfTouchVector(-1)),
    "no steps": (ValueError, lambda env, three: SelfTouch(frame_skip=0)),
    "no such model": (FileNotFoundError, lambda env, three: SelfTouch("no/such.xml")),
    "no such joints": (bs.Error, lambda env, three: SelfTouch(joints="nobody")),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_use_is_an_exception(env: Any, three: Any, name: str) -> None:
    kind, call = WRONG[name]
    with pytest.raises(kind) as raised:
        call(env.unwrapped, three.unwrapped)
    assert len(str(raised.value)) > 10


def test_what_is_closed_cannot_be_stepped() -> None:
    for closed in [SelfTouch(), SelfTouchVector(2)]:
        closed.reset(seed=1)
        closed.close()
        for use in [closed.reset, lambda closed=closed: closed.step(closed.action_space.sample())]:
            with pytest.raises(bs.Error, match="the environment is closed"):
                use()


def test_a_forked_process_steps_its_own(python: Callable[[str], str]) -> None:
    code = """
import multiprocessing as mp, numpy as np, bodyschema.environment as be
envs = be.SelfTouchVector(4)
envs.reset(seed=1)
action = np.stack([envs._crowd.start] * 4)
first = envs.step(action)[0]
def child(_):
    envs.reset(seed=1)
    return envs.step(action)[0]
with mp.get_context("fork").Pool(2) as pool:
    assert all(np.array_equal(of, first) for of in pool.map(child, range(2)))
print("done")
"""
    assert python(code) == "done\n"


def test_steps_and_environments_leave_nothing_behind(python: Callable[[str], str]) -> None:
    code = """
import resource, numpy as np, bodyschema.environment as be
envs = be.SelfTouchVector(2)
envs.reset(seed=1)
action = envs.action_space.sample()
def steps(count):
    for k in range(count):
        envs.step(action)
        if k % 100 == 0: envs.reset(seed=k)
def made(count):
    for _ in range(count):
        be.SelfTouchVector(8).close()
memory = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
steps(500); made(5)
before = memory()
steps(3_000); made(10)
print(memory() - before)
"""
    assert int(python(code)) < 8000
