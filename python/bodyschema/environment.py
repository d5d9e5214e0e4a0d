"""Gymnasium environments of creatures that feel themselves: `bodyschema/Max-v0`, or any creature by the path of its model.

    import gymnasium as gym
    import bodyschema.environment

    env = gym.make("bodyschema/Max-v0")
    envs = gym.make_vec("bodyschema/Max-v0", num_envs=64)                # in threads, without copies
    ant = gym.make("bodyschema/Max-v0", model="ant.xml", joints="all")

An action is a target for each coordinate of the posture: radians of hinges, metres of slides, quaternions (w, x, y, z) of balls.
Servos move the joints there under gravity, at 1.25 rad/s at most. Limbs press on each other; the root is fixed. An observation is
a row of float32: the D coordinates of the posture, then the force on each of the R receptors of the skin in newtons, in the order
of `Creature.receptors`. The reward is the number of receptors that are touched for the first time in the episode.
`info["touches"]` has the pairs of receptors that press on each other: (K, 2), rows of `Creature.receptors`.
"""

from __future__ import annotations

import os
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from ._core import Creature, Crowd, Error

__all__ = ["SelfTouch", "SelfTouchVector"]

#: Seconds from one action to the next.
_ACTION_TIME = 0.01
#: The share of its range by which a joint is off the start posture at the most when an episode begins.
_START_SPREAD = 0.02

_Floats = NDArray[np.float32]
_Info = dict[str, Any]


class _Crowd:
    """Creatures that are stepped together, with what is known of their episodes."""

    def __init__(self, model: str | os.PathLike[str], joints: str | None, frame_skip: int | None, count: int) -> None:
        self.creature = Creature(model, joints=joints)
        self.crowd: Crowd | None = Crowd(self.creature, count)
        self.skip = round(_ACTION_TIME / self.crowd.timestep) if frame_skip is None else frame_skip
        if self.skip < 1:
            raise ValueError(f"frame_skip: it is {frame_skip}: give a number from 1 on")
        self.action_time = self.skip * self.crowd.timestep
        self.start, self.ranges = self.crowd.start, self.creature.ranges
        # A quaternion is left as it is.
        moves = np.array([not name.endswith((".w", ".x", ".y", ".z")) for name in self.creature.coordinates])
        self.spread = moves * _START_SPREAD * np.ptp(self.ranges, axis=1)
        coordinates = len(self.start)
        width = coordinates + len(self.creature.receptors["id"])
        low = np.full(width, -np.inf, np.float32)
        low[coordinates:] = 0
        self.observation_space = gym.spaces.Box(low, np.inf, (width,), np.float32)
        self.action_space = gym.spaces.Box(*self.ranges.T.astype(np.float32), dtype=np.float32)
        self.touched = np.zeros((count, width - coordinates), bool)

    def open(self) -> Crowd:
        if self.crowd is None:
            raise Error("the environment is closed: make another one")
        return self.crowd

    def place(self, which: list[int], generators: list[np.random.Generator], posture: ArrayLike | None = None) -> _Floats:
        drawn = [self.start + self.spread * generator.uniform(-1, 1, len(self.start)) for generator in generators]
        postures = np.clip(drawn, *self.ranges.T) if posture is None else np.array([posture] * len(which))
        self.open().place(which, postures)
        self.touched[which] = False
        return np.hstack([postures, np.zeros((len(which), self.touched.shape[1]))]).astype(np.float32)

    def step(self, actions: ArrayLike) -> tuple[_Floats, NDArray[np.float64], NDArray[np.int64]]:
        observations, touches = self.open().step(actions, self.skip)
        touching = observations[:, len(self.start) :] > 0
        new = touching & ~self.touched
        self.touched |= touching
        return observations, new.sum(axis=1).astype(np.float64), touches


def _posture_of(options: _Info | None) -> ArrayLike | None:
    for name in options or {}:
        if name != "posture":
            raise ValueError(f"there is no option {name}: choose posture, the one to start in")
    return (options or {}).get("posture")


class SelfTouch(gym.Env[_Floats, _Floats]):
    """One creature.

    Parameters
    ----------
    model, joints
        As of `Creature`.
    frame_skip : int, optional
        Steps of the physics per action. By default those of 10 ms.

    Its attribute `creature` is the creature, `start` the posture near which episodes begin, (D,), and `action_time` the time from
    one action to the next, seconds.
    """

    metadata = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self, model: str | os.PathLike[str] = "max", *, joints: str | None = None, frame_skip: int | None = None
    ) -> None:
        self._crowd = _Crowd(model, joints, frame_skip, 1)
        self.creature, self.start, self.action_time = self._crowd.creature, self._crowd.start, self._crowd.action_time
        self.observation_space, self.action_space = self._crowd.observation_space, self._crowd.action_space

    def reset(self, *, seed: int | None = None, options: _Info | None = None) -> tuple[_Floats, _Info]:
        """Puts it near its start posture, or into `options["posture"]` (D,), at rest."""
        super().reset(seed=seed)
        return self._crowd.place([0], [self.np_random], _posture_of(options))[0], {}

    def step(self, action: ArrayLike) -> tuple[_Floats, float, bool, bool, _Info]:
        """Moves towards a posture, (D,)."""
        observations, rewards, touches = self._crowd.step(np.asarray(action)[None])
        return observations[0], float(rewards[0]), False, False, {"touches": touches[:, 1:]}

    def close(self) -> None:
        """Frees its memory."""
        self._crowd.crowd = None


class SelfTouchVector(VectorEnv[_Floats, _Floats, NDArray[Any]]):
    """Several creatures, stepped in parallel by threads. An episode that is over begins anew in the next step.

    Parameters
    ----------
    num_envs : int
        How many.
    model, joints, frame_skip
        As of `SelfTouch`.
    max_episode_steps : int, optional
        Steps after which an episode is truncated.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        model: str | os.PathLike[str] = "max",
        *,
        joints: str | None = None,
        frame_skip: int | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        self._crowd = _Crowd(model, joints, frame_skip, num_envs)
        self.creature, self.start, self.action_time = self._crowd.creature, self._crowd.start, self._crowd.action_time
        self.num_envs = num_envs
        self.single_observation_space, self.single_action_space = self._crowd.observation_space, self._crowd.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._most_steps = np.iinfo(np.int64).max if max_episode_steps is None else max_episode_steps
        self._steps = np.zeros(num_envs, np.int64)
        self._generators = [seeding.np_random()[0] for _ in range(num_envs)]

    def reset(self, *, seed: int | list[int | None] | None = None, options: _Info | None = None) -> tuple[_Floats, _Info]:
        """As of `SelfTouch`; environment i has the seed `seed + i`, or `seed[i]`."""
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else list(seed)
            if len(seeds) != self.num_envs:
                raise ValueError(f"seed: there are {len(seeds)}: give one number, or {self.num_envs}")
            self._generators = [seeding.np_random(of)[0] for of in seeds]
        self._steps[:] = 0
        return self._crowd.place(list(range(self.num_envs)), self._generators, _posture_of(options)), {}

    def step(self, actions: ArrayLike) -> tuple[_Floats, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], _Info]:
        """Moves all of them towards postures, (num_envs, D)."""
        observations, rewards, touches = self._crowd.step(actions)
        over = np.flatnonzero(self._steps >= self._most_steps)
        self._steps += 1
        if len(over):
            observations[over] = self._crowd.place(over.tolist(), [self._generators[i] for i in over])
            rewards[over], self._steps[over] = 0, 0
            touches = touches[~np.isin(touches[:, 0], over)]
        of_each = np.empty(self.num_envs, object)
        for i, pairs in enumerate(np.split(touches[:, 1:], np.searchsorted(touches[:, 0], range(1, self.num_envs)))):
            of_each[i] = pairs
        info = {"touches": of_each, "_touches": np.ones(self.num_envs, bool)}
        return observations, rewards, np.zeros(self.num_envs, bool), self._steps >= self._most_steps, info

    def close_extras(self, **kwargs: Any) -> None:
        """Frees their memory."""
        self._crowd.crowd = None


gym.register(
    id="bodyschema/Max-v0",
    entry_point="bodyschema.environment:SelfTouch",
    vector_entry_point="bodyschema.environment:SelfTouchVector",
    max_episode_steps=1000,
)
