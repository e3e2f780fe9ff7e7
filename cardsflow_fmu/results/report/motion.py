"""Figure of an optimal motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from cardsflow_fmu.utils.arrays import FloatArray

from .figures import figure_of_panels
from .panels import Curve, Panel

_PANELS = {
    "q": "position [rad, m]",
    "qd": "velocity [rad/s, m/s]",
    "f": "force [N]",
    "tau": "torque [N·m, N]",
}


def motion_figure(
    times: FloatArray, columns: Mapping[str, FloatArray], title: str, bounds: Sequence[Curve] = ()
) -> Figure:
    """Return a figure of joint positions, velocities and forces over time.

    Args:
        times: Times of the samples, shape (k,), in [s].
        columns: Samples by name, such as `q.elbow`.
        title: Title of the figure.
        bounds: Bounds as references of the curves.
    """
    panels = []
    for letter, label in _PANELS.items():
        names = [name for name in columns if name.startswith(f"{letter}.")]
        if names:
            curves = [Curve(name, times, columns[name]) for name in names]
            panels.append(Panel(label, [*curves, *(b for b in bounds if b.of in names)]))
    return figure_of_panels(panels, title=title)
