"""What tests share: Max, his touches and what he learned of them."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import bodyschema as bs
import pytest

REPOSITORY = Path(__file__).parents[2]
ROBOT = REPOSITORY / "examples" / "robot"
MAX = REPOSITORY / "mjcf" / "max" / "max.xml"
BODIES = REPOSITORY / "mjcf" / "bodies"


@pytest.fixture(scope="session")
def creature() -> bs.Creature:
    return bs.Creature("max")


@pytest.fixture(scope="session")
def session(creature: bs.Creature) -> bs.Session:
    return bs.babble(creature, seed=1)


@pytest.fixture(scope="session")
def schema(session: bs.Session) -> bs.Schema:
    return bs.learn(session)


@pytest.fixture(scope="session")
def crane() -> bs.Creature:
    """A creature with slides."""
    return bs.Creature(BODIES / "crane.xml")


@pytest.fixture(scope="session")
def fit() -> bs.Fit:
    return bs.calibrate(bs.Robot(ROBOT / "arms.urdf"), ROBOT / "touches.csv", free=["*.offset"], held_out=0.3)


@pytest.fixture(scope="session")
def python() -> Callable[[str], str]:
    """Runs some Python in a process of its own and returns what it prints."""

    def run(code: str) -> str:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, f"{done.returncode}: {done.stderr}"
        return done.stdout

    return run


@pytest.fixture(scope="session")
def program() -> Path:
    """The program, if there is one with the same MuJoCo."""
    path = Path(os.environ.get("BODYSCHEMA_PROGRAM", REPOSITORY / "target" / "debug" / "bodyschema"))
    if not path.is_file():
        pytest.skip(f"there is no program at {path}: build it, or name it by BODYSCHEMA_PROGRAM")
    return path
