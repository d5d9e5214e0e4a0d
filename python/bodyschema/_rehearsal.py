"""Models are read in a process of their own first: a foreign file can crash MuJoCo, or keep it busy for ever."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

from ._core import Error

#: Seconds of a core that a file may take to load, and bytes of memory.
_SECONDS, _MEMORY = 20, 8 << 30
_CODE = f"""
import resource, sys
for of, most in [(resource.RLIMIT_CPU, {_SECONDS}), (resource.RLIMIT_AS, {_MEMORY}), (resource.RLIMIT_CORE, 0)]:
    soft, hard = resource.getrlimit(of)
    most = min([most, *(limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY)])
    resource.setrlimit(of, (most, most))
sys.path[:0] = [{os.path.dirname(os.path.dirname(__file__))!r}]
from bodyschema._core import rehearse
try:
    rehearse(sys.argv[1])
except Exception:
    pass
"""


def rehearse(model: str | os.PathLike[str]) -> None:
    """Raises an error if MuJoCo does not survive a model. Whatever else is wrong with it is found where it is read."""
    if not sys.executable or not os.path.isfile(model):
        return
    done = subprocess.run(
        [sys.executable, "-c", _CODE, os.fspath(model)], stdin=subprocess.DEVNULL, capture_output=True, check=False
    )
    if done.returncode >= 0:
        return
    number = -done.returncode
    reason = f"MuJoCo crashes on it (signal {number})"
    if number in (signal.SIGXCPU, signal.SIGKILL):
        reason = f"MuJoCo did not come to an end with it in {_SECONDS} s"
    raise Error(f"{model}: {reason}; look for huge numbers, sizes and meshes in it, or remove parts of it")
