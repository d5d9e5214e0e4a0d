"""Plots by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ._core import Schema, Session
    from ._fit import Fit


def _axes(ax: Any, **options: Any) -> Any:
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError:
        raise ImportError("plots need matplotlib: pip install matplotlib") from None
    return pyplot.figure(layout="constrained").add_subplot(**options)


def touches(session: Session, ax: Any = None) -> Any:
    """How often limbs touched one another, as a matrix."""
    ax = _axes(ax)
    table = session.touches
    limbs = list(dict.fromkeys([*table["limb_a"], *table["limb_b"]]))
    place = {limb: k for k, limb in enumerate(limbs)}
    counts = np.zeros((len(limbs), len(limbs)))
    for a, b in zip(table["limb_a"], table["limb_b"], strict=True):
        counts[place[a], place[b]] += 1
        counts[place[b], place[a]] += 1
    image = ax.imshow(np.where(counts > 0, counts, np.nan))
    ax.set_xticks(range(len(limbs)), limbs, rotation=90)
    ax.set_yticks(range(len(limbs)), limbs)
    ax.figure.colorbar(image, ax=ax, label="touches")
    return ax


def body(schema: Schema, q: Any = None, ax: Any = None) -> Any:
    """The tree of joints in a posture, in the root's frame; limbs that are not located are dotted."""
    ax = _axes(ax, projection="3d")
    posture = schema.reference_posture if q is None else q
    places = np.array([schema.pose(limb, posture)[:3, 3] for limb, _ in schema.tree])
    located = set(schema.located)
    for limb, (name, parent) in enumerate(schema.tree):
        if parent >= 0:
            line = places[[parent, limb]]
            ax.plot(*line.T, "-" if name in located else ":", color="C0", marker="o", markersize=3)
    ax.set_aspect("equal")
    ax.set(xlabel="x, m", ylabel="y, m", zlabel="z, m")
    return ax


def quantities(fit: Fit, ax: Any = None) -> Any:
    """How far quantities changed, with their standard deviations."""
    ax = _axes(ax)
    table = fit.quantities
    deviations = [np.linalg.norm([d for d in of if d is not None]) for of in table["deviation"]]
    places = range(len(deviations))
    ax.errorbar(table["change"], places, xerr=deviations, fmt="o", capsize=3)
    ax.set_yticks(places, table["name"])
    ax.set_xlabel("change, m or rad")
    return ax
