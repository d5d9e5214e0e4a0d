"""The compiled part of the package; each function's documentation is in it."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, TypedDict, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from ._fit import Fit
from ._reach import Reach, Reachable
from ._tables import Record, Table

__all__ = [
    "Creature",
    "Crowd",
    "Error",
    "Fitted",
    "Robot",
    "Schema",
    "Session",
    "__version__",
    "babble",
    "calibrate",
    "evaluate",
    "learn",
    "mujoco_version",
    "open",
    "record",
    "rehearse",
    "study",
]

_Path: TypeAlias = str | PathLike[str]
_Floats: TypeAlias = NDArray[np.float64]

__version__: str

class Error(Exception): ...

class _Summary(Record):
    mean: float
    median: float
    p95: float
    max: float

class _Bound(Record):
    bound_rms: float
    error_rms: float
    ratio: float
    points: int
    at_floor: bool

class _Evaluation(Record):
    heldout_mm: _Summary
    determined_mm: _Summary
    bound_mm: _Bound | None
    hand_mm: _Summary | None
    axis_deg: _Summary
    axis_line_mm: _Summary

class _Learning(TypedDict, total=False):
    learner: Literal["lm", "growth", "hersch"] | None
    input: Literal["receptor", "contact"] | None
    skin: Literal["surface", "centres"] | None
    frames: Literal["joint", "limb"] | None
    known: _Path | None
    joint_noise_deg: float | None
    receptor_noise_mm: float | None
    point_noise_mm: float | None
    false_touches: float | None

@final
class Creature:
    def __new__(cls, model: _Path = "max", *, joints: str | None = None, root: str | None = None) -> Creature: ...
    @property
    def name(self) -> str: ...
    @property
    def model(self) -> str: ...
    @property
    def limbs(self) -> list[str]: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def coordinates(self) -> list[str]: ...
    @property
    def dof(self) -> int: ...
    @property
    def ranges(self) -> _Floats: ...
    @property
    def reference_posture(self) -> _Floats: ...
    @property
    def receptors(self) -> Table: ...
    def sample_postures(self, n: int, *, seed: int = 1) -> _Floats: ...

@final
class Crowd:
    def __new__(cls, creature: Creature, count: int) -> Crowd: ...
    @property
    def start(self) -> _Floats: ...
    @property
    def timestep(self) -> float: ...
    def place(self, which: Sequence[int], postures: ArrayLike) -> None: ...
    def step(self, targets: ArrayLike, steps: int) -> tuple[NDArray[np.float32], NDArray[np.int64]]: ...

@final
class Session:
    @property
    def creature(self) -> str: ...
    @property
    def seed(self) -> int: ...
    @property
    def engine(self) -> str: ...
    @property
    def folder(self) -> PathLike[str] | None: ...
    @property
    def interrupted(self) -> bool: ...
    @property
    def touches(self) -> Table: ...
    @property
    def postures(self) -> _Floats: ...
    @property
    def receptors(self) -> NDArray[np.int64]: ...
    @property
    def points(self) -> _Floats: ...
    def save(self, folder: _Path) -> None: ...
    def plot(self, ax: Any = None) -> Any: ...
    def _repr_html_(self) -> str: ...
    def __len__(self) -> int: ...

@final
class Schema:
    @property
    def verdict(self) -> str: ...
    @property
    def converged(self) -> bool: ...
    @property
    def located(self) -> list[str]: ...
    @property
    def unlocated(self) -> dict[str, str]: ...
    @property
    def account(self) -> Table: ...
    @property
    def positions(self) -> _Floats: ...
    @property
    def axes(self) -> _Floats: ...
    @property
    def tree(self) -> list[tuple[str, int]]: ...
    @property
    def reference_posture(self) -> _Floats: ...
    def pose(self, limb: str | Sequence[str], q: ArrayLike, *, wrt: str | None = None) -> _Floats: ...
    def jacobian(self, limb: str | Sequence[str], q: ArrayLike, *, wrt: str | None = None) -> _Floats: ...
    def position_std(self, limb: str, q: ArrayLike, *, wrt: str | None = None, point: ArrayLike | None = None) -> _Floats: ...
    def reach(self, limb: str, point: ArrayLike) -> Reach: ...
    def reachable(self, limb: str, voxel: float = 0.02) -> Reachable: ...
    def save(self, path: _Path) -> None: ...
    def html(self) -> str: ...
    def plot(self, q: ArrayLike | None = None, ax: Any = None) -> Any: ...
    def _repr_html_(self) -> str: ...

@final
class Robot:
    def __new__(cls, path: _Path) -> Robot: ...
    @property
    def name(self) -> str: ...
    @property
    def quantities(self) -> list[str]: ...
    @property
    def joints(self) -> list[str]: ...

@final
class Fitted:
    def save(self, path: _Path) -> None: ...
    def html(self) -> str: ...

def babble(
    creature: Creature,
    *,
    touches: int | None = None,
    seed: int = 1,
    seconds: float | None = None,
    work: float | None = None,
    policy: Literal["stages", "random"] | None = None,
    motion: Literal["kinematic", "dynamic"] = "kinematic",
    jobs: int | None = None,
    out: _Path | None = None,
    **learning: Unpack[_Learning],
) -> Session: ...
def learn(session: Session, *, touches: int | None = None, **learning: Unpack[_Learning]) -> Schema: ...
def record(
    creature: Creature,
    postures: ArrayLike,
    receptors: ArrayLike,
    points: ArrayLike | None = None,
    *,
    seed: int = 1,
) -> Session: ...
def open(folder: _Path) -> tuple[Session, Schema | None]: ...
def evaluate(schema: Schema, creature: Creature) -> _Evaluation: ...
def calibrate(
    robot: Robot,
    log: _Path,
    *,
    free: str | Sequence[str] | None = None,
    prior: Mapping[str, float] | None = None,
    fix: str | Sequence[str] | None = None,
    held_out: float | _Path | None = None,
    folds: int | None = None,
    joint_noise: float | None = 0.0,
    false_touches: bool = True,
    seed: int = 1,
) -> Fit: ...
def study(
    name: Literal["bodies", "learners", "hersch", "disturbances", "acting", "senses", "calibration"],
    *,
    seeds: Sequence[int],
    cases: Sequence[str] | None = None,
    touches: int | None = None,
    work: float | None = None,
    creature: Creature | None = None,
) -> Table: ...
def rehearse(model: _Path) -> None: ...
def mujoco_version() -> str: ...
