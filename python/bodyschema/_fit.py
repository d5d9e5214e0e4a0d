"""What a calibration found."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any

from . import _html, _plot
from ._tables import Record, Table, columns, record

if TYPE_CHECKING:
    from ._core import Fitted


class Fit:
    """What a calibration found: the quantities with their deviations, and what held-out touches say of them."""

    def __init__(self, fitted: Fitted, found: str) -> None:
        self._fitted = fitted
        #: All that was found, in metres and radians, as the program's `--json` prints it.
        self.details: Record = record(found)

    @property
    def verdict(self) -> str:
        """The verdict in a sentence: what speaks against the result, if anything does."""
        return str(self.details.verdict)

    @property
    def calibrated(self) -> bool:
        """Whether nothing speaks against it."""
        return bool(self.details.calibrated)

    @property
    def quantities(self) -> Table:
        """The quantities that were estimated as a table of columns: `name`, `unit`, `before`, `after`, `change`, `deviation` (one
        standard deviation), metres and radians; lists of vectors' components."""
        return columns(self.details.quantities)

    @property
    def undetermined(self) -> list[str]:
        """The quantities that these touches do not determine, in sentences."""
        return list(self.details.untold)

    @property
    def held_out(self) -> Record | None:
        """Contact residuals of held-out touches at the values found, metres: `rms`, `median`, `p95`, `max`; of several parts the
        mean. None if nothing was held out."""
        return self.details.held_out_after if self.details.held_out else None

    @property
    def before(self) -> Record:
        """Contact residuals of all touches at the maker's values, metres: `rms`, `median`, `p95`, `max`."""
        return Record(self.details.before)

    @property
    def after(self) -> Record:
        """The same at the values found."""
        return Record(self.details.after)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the robot's file with the calibrated numbers and nothing else changed. A warning names what the format
        has no place for."""
        self._fitted.save(path)

    def html(self) -> str:
        """The report as one page of HTML, which stands alone."""
        return self._fitted.html()

    def plot(self, ax: Any = None) -> Any:
        """Draws the changes of all quantities with their deviations; needs matplotlib. Returns the axes."""
        return _plot.quantities(self, ax)

    def _repr_html_(self) -> str:
        return _html.page(self)

    def __repr__(self) -> str:
        return f"<Fit of {self.details.robot}: {self.verdict}>"
