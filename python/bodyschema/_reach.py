"""What reaching comes to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Reach:
    """What came of reaching for a point. It is true if the point is reached."""

    #: The posture that reaches the point: (D,), radians and metres; None if there is none.
    posture: NDArray[np.float64] | None
    #: Why the point is not reached; None if it is.
    reason: str | None
    #: How far off the limb's tip stays, metres.
    miss: float
    #: "near" if the limb's own joints reach it, "far" if the joints before them must move as well.
    level: Literal["near", "far", "out of reach"]

    def __bool__(self) -> bool:
        return self.posture is not None


@dataclass(frozen=True, eq=False, repr=False)
class Reachable:
    """Where a limb gets to: the voxels that its tip reaches."""

    #: The limb that reaches.
    limb: str
    #: The side of a voxel, metres.
    voxel: float
    #: The volume that is reached, m³.
    volume: float
    #: The middles of the voxels that are reached, in the root's frame: (M, 3), metres.
    points: NDArray[np.float64]
    #: Whether the limb's own joints reach them, without those before: (M,).
    near: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"<Reachable of {self.limb}: {1e3 * self.volume:.1f} litres>"
