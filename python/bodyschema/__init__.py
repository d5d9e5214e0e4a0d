"""A creature in MuJoCo learns its body schema from nothing but self-touch.

    import bodyschema as bs

    creature = bs.Creature("max")
    session = bs.babble(creature, seed=1)
    schema = bs.learn(session)
    print(schema.verdict)
    q = creature.sample_postures(1000, seed=2)
    poses = schema.pose("left_hand", q)

Metres, radians, seconds and newtons throughout; frames and shapes stand in each function's documentation.
"""

from ._core import (
    Creature,
    Error,
    Robot,
    Schema,
    Session,
    __version__,
    babble,
    calibrate,
    evaluate,
    learn,
    mujoco_version,
    open,
    record,
    study,
)
from ._fit import Fit
from ._progress import progress
from ._reach import Reach, Reachable
from ._tables import Record, Table

__all__ = [
    "Creature",
    "Error",
    "Fit",
    "Reach",
    "Reachable",
    "Record",
    "Robot",
    "Schema",
    "Session",
    "Table",
    "__version__",
    "babble",
    "calibrate",
    "evaluate",
    "learn",
    "mujoco_version",
    "open",
    "progress",
    "record",
    "study",
]
