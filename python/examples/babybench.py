"""MIMo touches himself: the self-touch measure of BabyBench 2025, and a policy that recalls what babbling felt.

    python python/examples/babybench.py MIMo/mimoEnv/assets/selfbody_scene.xml

needs MIMo (https://github.com/trieschlab/MIMo), `pip install 'bodyschema[gym]'` and some minutes. The measure counts MIMo's geoms
that each hand touched in an episode of 1,000 steps, out of the 34 that are not its own. Joined limbs do not collide in MuJoCo: a
hand never touches its fingers (2 geoms) and its lower arm (1), so that 62 of 68 are possible.

The policy knows no geometry. It remembers postures in which a hand felt a touch while babbling, goes with both hands at once to
those of touches that it has not yet felt in the episode, and keeps in mind which attempts led to a touch.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import bodyschema as bs
import numpy as np
from bodyschema.environment import SelfTouch
from numpy.typing import ArrayLike, NDArray

#: A hand and the geom that it touches.
Pair = tuple[str, int]

HANDS = ("left_hand", "right_hand")
#: The most of a score.
MOST = 2 * 34
#: How fast joints are expected to move, rad/s, and the time that an attempt takes besides, s.
SPEED, PAUSE = 1.25, 0.3
#: How far beyond the remembered posture a hand presses, radians of the joint that moves most.
PRESSING = 0.25
#: How far an attempt that failed before is varied, radians.
VARIATION = 0.15
#: A hand whose joints all moved less than this, radians, in so many seconds is stuck …
STUCK, STUCK_TIME = 0.03, 0.2
#: … and lets go for so long.
RELEASE_TIME = 0.3


def touched(creature: bs.Creature, touches: ArrayLike, hands: Iterable[str] = HANDS) -> set[Pair]:
    """The geoms that hands touch, of pairs of receptors (K, 2).

    BabyBench's own code counts what both hands touch of each other for the right one alone: at most 60 by it.
    """
    limbs, geoms = creature.receptors["limb"], creature.receptors["geom"]
    both = np.asarray(touches).reshape(-1, 2)
    return {(limbs[a], int(geoms[b])) for a, b in np.vstack([both, both[:, ::-1]]) if limbs[a] in hands}


@dataclass
class Memory:
    """What is remembered of a pair: postures (M, D) of its touches, how often each was tried and led to the touch."""

    joints: NDArray[np.bool_]
    postures: NDArray[np.float64]
    tried: NDArray[np.float64]
    felt: NDArray[np.float64]


@dataclass
class Attempt:
    """A hand on its way: the pair, the index of the remembered posture, where its joints go, from when until when, in steps."""

    pair: Pair
    index: int
    joints: NDArray[np.bool_]
    aim: NDArray[np.float64]
    begun: int
    end: int


class Recall:
    """A policy of postures and touches.

    Parameters
    ----------
    creature, schema
        The creature and what it learned of its body: of this, which joints move a hand against another limb.
    step_time
        Seconds from one action to the next.
    rest
        The posture to which joints go that no attempt needs, (D,).
    """

    def __init__(
        self, creature: bs.Creature, schema: bs.Schema, step_time: float, rest: ArrayLike, hands: tuple[str, str] = HANDS
    ) -> None:
        self.creature, self.hands, self.step_time, self.rest = creature, hands, step_time, np.array(rest, float)
        some = creature.sample_postures(20)
        limb_of = dict(zip(creature.receptors["geom"].tolist(), creature.receptors["limb"], strict=True))
        self.joints = {
            (hand, geom): np.abs(schema.jacobian(hand, some, wrt=limb)).max(axis=(0, 1)) > 1e-6
            for hand in hands
            for geom, limb in limb_of.items()
        }
        self.memory: dict[Pair, Memory] = {}
        self.random = np.random.default_rng(1)
        self.begin()

    def remember(self, pair: Pair, postures: ArrayLike, felt: float = 0.0) -> None:
        """Keeps postures (M, D) in which a pair touched, and how often they were reached in an episode."""
        postures = np.atleast_2d(np.asarray(postures, float))
        counts = np.full(len(postures), felt)
        memory = self.memory.get(pair, Memory(self.joints[pair], postures[:0], counts[:0], counts[:0]))
        memory.postures = np.vstack([memory.postures, postures])
        memory.tried, memory.felt = np.append(memory.tried, counts), np.append(memory.felt, counts)
        self.memory[pair] = memory

    def babbled(self, session: bs.Session, most: int = 200) -> None:
        """Remembers the touches of a session, of each pair so many."""
        found: dict[Pair, list[Any]] = {}
        for posture, pair in zip(session.postures, session.receptors, strict=True):
            for touch in touched(self.creature, pair, self.hands):
                found.setdefault(touch, []).append(posture)
        for touch, postures in found.items():
            self.remember(touch, postures[:most])

    def settle(self) -> None:
        """Rests from now on in the middle of the postures that it remembers, from where none of them is far."""
        for k in range(len(self.rest)):
            middles = [np.median(memory.postures[:, k]) for memory in self.memory.values() if memory.joints[k]]
            if middles:
                self.rest[k] = np.median(middles)

    def begin(self) -> None:
        """An episode begins."""
        self.felt: set[Pair] = set()
        self.attempts: dict[str, Attempt] = {}
        self.tries: dict[Pair, int] = {}
        self.released = dict.fromkeys(self.hands, 0)
        self.past: list[NDArray[np.float64]] = []

    def feel(self, posture: ArrayLike, touches: set[Pair]) -> None:
        """Takes note of what touches in the present posture."""
        for pair in touches - self.felt:
            self.felt.add(pair)
            self.remember(pair, posture, felt=1.0)

    def act(self, posture: ArrayLike) -> NDArray[np.float64]:
        """The posture to go to from the present one, (D,)."""
        now, time = np.asarray(posture, float), len(self.past)
        self.past.append(now)
        for hand in self.hands:
            attempt = self.attempts.get(hand)
            if attempt is not None and self.over(attempt, time):
                memory = self.memory[attempt.pair]
                memory.tried[attempt.index] += 1
                memory.felt[attempt.index] += attempt.pair in self.felt
                del self.attempts[hand]
                if attempt.pair not in self.felt:
                    self.released[hand] = time + round(RELEASE_TIME / self.step_time)
            if hand not in self.attempts and time >= self.released[hand]:
                self.attempt(hand, now, time)
        target: NDArray[np.float64] = self.rest.copy()
        for attempt in self.attempts.values():
            target[attempt.joints] = attempt.aim[attempt.joints]
        return target

    def over(self, attempt: Attempt, time: int) -> bool:
        """Whether an attempt succeeded, or is given up."""
        before = round(STUCK_TIME / self.step_time)
        waited = time - attempt.begun > 2 * before
        stuck = waited and np.abs(self.past[-1] - self.past[-1 - before])[attempt.joints].max() < STUCK
        return attempt.pair in self.felt or time >= attempt.end or bool(stuck)

    def attempt(self, hand: str, now: NDArray[np.float64], time: int) -> None:
        """Begins the attempt that is expected to take least time until a new touch, if one can go along with the other hand's."""
        others = [attempt for other, attempt in self.attempts.items() if other != hand]
        best, least = None, np.inf
        for pair, memory in self.memory.items():
            if pair[0] != hand or pair in self.felt:
                continue
            away = np.abs(memory.postures - now)[:, memory.joints].max(axis=1)
            chance = (memory.felt + 1) / (memory.tried + 2)
            cost = (away / SPEED + PAUSE) / chance * (1 + self.tries.get(pair, 0))
            for other in others:
                shared = memory.joints & other.joints
                cost[(np.abs(memory.postures - other.aim) > 0.2)[:, shared].any(axis=1)] = np.inf
            index = int(cost.argmin())
            if cost[index] < least:
                best, least = (pair, memory, index, float(away[index])), cost[index]
        if best is None:
            return
        pair, memory, index, distance = best
        tries = self.tries.get(pair, 0)
        self.tries[pair] = tries + 1
        aim = memory.postures[index] + PRESSING * (memory.postures[index] - now) / max(distance, 1e-9)
        if tries:
            aim += self.random.normal(0, VARIATION, len(aim))
        end = time + round((1.1 * distance / SPEED + PAUSE) / self.step_time)
        self.attempts[hand] = Attempt(pair, index, memory.joints, aim, time, end)


def episode(env: SelfTouch, policy: Recall, seed: int, steps: int = 1000) -> set[Pair]:
    """What each hand touched in an episode of the environment: the measure is its number over `MOST`."""
    observation, _ = env.reset(seed=seed)
    policy.begin()
    width = len(policy.rest)
    found: set[Pair] = set()
    for _ in range(steps):
        observation, _, _, _, info = env.step(policy.act(observation[:width]))
        touches = touched(env.creature, info["touches"], policy.hands)
        policy.feel(observation[:width], touches)
        found |= touches
    return found


class StarterKit:
    """The policy in BabyBench's starter kit, whose `evaluation.py` leaves the call of a policy open.

    env = babybench.utils.make_env(config, training=False)      # with `actuation_model: positional`
    creature = bs.Creature(f"{config['save_dir']}/scene.xml")   # learn, and let a Recall practise, as in `main`
    policy = StarterKit(env, recall)
    obs, _ = env.reset()
    info = {}
    for step in range(1000):
        obs, _, _, _, info = env.step(policy(obs, info))
        evaluation.eval_step(info)
    """

    def __init__(self, env: Any, recall: Recall) -> None:
        self.recall, inner = recall, env.unwrapped
        coordinates = recall.creature.coordinates
        names = list(inner.proprioception.joint_names)
        actuated = [inner.model.joint(joint).name for joint in inner.model.actuator_trnid[:, 0]]
        # Where in an observation each coordinate is; what is not there stays at rest.
        self.observed = [(k, names.index(name)) for k, name in enumerate(coordinates) if name in names]
        self.actuated = [coordinates.index(name) for name in actuated]
        self.reach = SPEED * recall.step_time

    def __call__(self, obs: dict[str, Any], info: dict[str, Any]) -> NDArray[np.float32]:
        posture = self.recall.rest.copy()
        for coordinate, place in self.observed:
            posture[coordinate] = obs["observation"][place]
        touches = {(hand, int(geom)) for hand in HANDS for geom in info.get(f"{hand}_touches", [])}
        self.recall.feel(posture, touches)
        target = self.recall.act(posture)
        # The positional model jumps to its target, so that it is led there.
        return np.clip(target, posture - self.reach, posture + self.reach)[self.actuated].astype(np.float32)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="MIMo's selfbody_scene.xml")
    parser.add_argument("--frame-skip", type=int, default=50, help="steps of the physics per action")
    parser.add_argument("--touches", type=int, default=100_000, help="touches that are babbled at random")
    parser.add_argument("--practice", type=int, default=20, help="episodes in which the policy learns")
    parser.add_argument("--episodes", type=int, default=5, help="episodes that are measured")
    options = parser.parse_args()

    creature = bs.Creature(options.scene)
    sessions = [bs.babble(creature, seed=seed) for seed in range(1, 5)]
    schema = bs.learn(sessions[0])
    print(schema.verdict)
    sessions.append(bs.babble(creature, touches=options.touches, policy="random", seed=5))

    env = SelfTouch(options.scene, frame_skip=options.frame_skip)
    policy = Recall(creature, schema, env.action_time, env.start)
    for session in sessions:
        policy.babbled(session)
    policy.settle()
    print(f"babbling felt {len(policy.memory)} of {MOST}")
    for seed in range(1000, 1000 + options.practice):
        print(f"practice: {len(episode(env, policy, seed))} of {MOST}", flush=True)
    scores = [len(episode(env, policy, seed)) for seed in range(options.episodes)]
    print(f"measured: {scores} of {MOST}, {np.mean(scores) / MOST:.2f} on average")


if __name__ == "__main__":
    main()
