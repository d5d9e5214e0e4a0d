"""Progress of long computations, by tqdm if it is installed."""

from __future__ import annotations

import sys
from typing import Any

_shown: bool | None = None


def progress(shown: bool | None) -> None:
    """Shows progress or not; with None where a person looks on: in a notebook or on a terminal."""
    global _shown
    _shown = shown


def _bar_type() -> Any:
    shown = _shown
    if shown is None:
        shown = "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())
    if not shown:
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm


class Progress:
    """A bar per phase."""

    def __init__(self) -> None:
        self._type = _bar_type()
        self._bar: Any = None
        self._phase = ""

    def show(self, phase: str, done: int, steps: int) -> None:
        """So many steps of a phase are done, of so many at most; 0 if that is not known."""
        if self._type is None:
            return
        if phase != self._phase:
            self.close()
            self._phase = phase
            if phase:
                self._bar = self._type(desc=phase, total=steps or None, leave=False)
        if self._bar is not None and done > self._bar.n:
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Removes the bar."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None
