"""Selection and colours of the curves in a panel."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex, to_rgb

from .panels import Curve, Panel

MAX_CURVES = 10
"""Maximum number of curves in a panel; more curves cannot be distinguished."""

_MAX_WHITE = 0.6  # fraction of white in the last colour of a group
_MAX_LETTERS = 28  # maximum length of a name in a legend


@dataclass(frozen=True, eq=False)
class SelectedCurves:
    """Selected curves of a panel."""

    curves: list[Curve]
    references: list[Curve]
    omitted: int


def select_curves(panel: Panel, count: int = MAX_CURVES) -> SelectedCurves:
    """Select the curves with the largest magnitude or change, and their references."""
    curves = [curve for curve in panel.curves if not curve.of]
    effects = np.array([_effect(curve, panel.by_change) for curve in curves])
    selected = sorted(np.argsort(-effects, kind="stable")[:count])
    drawn = [curves[k] for k in selected]
    names = {curve.name for curve in drawn}
    references = [curve for curve in panel.curves if curve.of in names]
    return SelectedCurves(drawn, references, len(curves) - len(drawn))


def _effect(curve: Curve, by_change: bool) -> float:
    values = curve.values[np.isfinite(curve.values)]
    if not values.size:
        return 0.0
    return float(np.ptp(values) if by_change else np.abs(values).max())


def curve_colours(names: Sequence[str]) -> list[str]:
    """Return a colour for each name: one hue per group, from dark to light.

    Names that only differ in their last number form a group, such as motor_1 and motor_2. If there
    is a single group, or if all groups have a single name, each name has its own hue.
    """
    hues = mpl.colormaps["tab10"].colors  # type: ignore[attr-defined]
    groups = [re.sub(r"\d+\D{0,2}$", "", name) for name in names]
    members = {group: groups.count(group) for group in groups}
    if len(members) in (1, len(names)):
        return [to_hex(hues[k % len(hues)]) for k in range(len(names))]
    hue_of = {group: hues[k % len(hues)] for k, group in enumerate(members)}
    colours = []
    for k, group in enumerate(groups):
        place = groups[:k].count(group) / max(1, members[group] - 1)
        white = _MAX_WHITE * place
        red, green, blue = (white + (1.0 - white) * channel for channel in to_rgb(hue_of[group]))
        colours.append(to_hex((red, green, blue)))
    return colours


def shorten(name: str) -> str:
    """Shorten a long name for a legend by omitting its middle."""
    if len(name) <= _MAX_LETTERS:
        return name
    head = (_MAX_LETTERS - 3) // 2
    return f"{name[:head]}...{name[head + 3 - _MAX_LETTERS :]}"
