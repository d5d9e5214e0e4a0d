"""What a notebook shows."""

from __future__ import annotations

import html
from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._core import Schema, Session
    from ._fit import Fit

#: Pairs of limbs that are named.
_PAIRS = 12


def page(found: Schema | Fit) -> str:
    """The report, in a frame of its own."""
    return (
        f'<iframe title="report" style="width: 100%; height: 640px; border: 0" sandbox="allow-scripts"'
        f' srcdoc="{html.escape(found.html())}"></iframe>'
    )


def touches(session: Session) -> str:
    """How often limbs touched one another."""
    table = session.touches
    pairs = Counter(zip(table["limb_a"], table["limb_b"], strict=True)).most_common()
    rows = "".join(
        f"<tr><td>{html.escape(a)}</td><td>{html.escape(b)}</td><td>{count}</td></tr>" for (a, b), count in pairs[:_PAIRS]
    )
    more = f"<p>and {len(pairs) - _PAIRS} more pairs</p>" if len(pairs) > _PAIRS else ""
    return (
        f"<p>{html.escape(repr(session)[1:-1])}</p>"
        f"<table><thead><tr><th>limb</th><th>limb</th><th>touches</th></tr></thead><tbody>{rows}</tbody></table>{more}"
    )
