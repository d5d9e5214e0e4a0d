"""Tables and records: what pandas, polars and people take."""

from __future__ import annotations

import html
import json
from typing import Any

import numpy as np

#: Rows of a table that a notebook shows.
_SHOWN = 10


class Table(dict[str, Any]):
    """A table as a dictionary of columns, NumPy arrays of one length: `pandas.DataFrame(table)`, `polars.DataFrame(table)`.

    With pyarrow installed it is an Arrow stream as well: `pyarrow.table(table)`, and whatever else reads those.
    """

    @property
    def rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.values()), ()))

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The table by Arrow's PyCapsule protocol."""
        import pyarrow

        return pyarrow.table(dict(self)).__arrow_c_stream__(requested_schema)

    def _repr_html_(self) -> str:
        def cell(value: Any) -> str:
            text = f"{value:.6g}" if isinstance(value, float) else str(value)
            return f"<td>{html.escape(text)}</td>"

        head = "".join(f"<th>{html.escape(name)}</th>" for name in self)
        shown = zip(*(list(column[:_SHOWN]) for column in self.values()), strict=True)
        body = "".join(f"<tr>{''.join(map(cell, row))}</tr>" for row in shown)
        more = f"<p>{self.rows} rows</p>" if self.rows > _SHOWN else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


class Record(dict[str, Any]):
    """A dictionary whose fields are attributes as well."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no {name}: choose one of {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


def record(found: Any) -> Any:
    """JSON, or what it was read as, with its objects as records."""
    return json.loads(found if isinstance(found, str) else json.dumps(found), object_hook=Record)


def columns(found: Any) -> Table:
    """A JSON array of objects, or what it was read as, as a table."""
    rows = json.loads(found) if isinstance(found, str) else found
    names = list(dict.fromkeys(name for row in rows for name in row))
    return Table({name: _column([row.get(name) for row in rows]) for name in names})


def _column(values: list[Any]) -> Any:
    given = [value for value in values if value is not None]
    if given and len(given) == len(values) and all(isinstance(value, bool) for value in given):
        return np.array(values, dtype=bool)
    if given and all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in given):
        if len(given) == len(values) and all(isinstance(value, int) for value in given):
            return np.array(values, dtype=np.int64)
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column
