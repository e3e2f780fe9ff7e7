"""Writer of trajectories in the XML format of CASPR and in .traj files."""

from __future__ import annotations

from itertools import accumulate, pairwise
from xml.etree import ElementTree

from ...caspr_vocabulary import CASPR_SPLINES
from ...model.trajectory import Trajectory, TrajectoryPoint
from ..writing.xml_text import element, numbers

TIME_TOLERANCE = 1e-9
"""Tolerance of the sample times, in [s]."""


def write_trajectory(group: ElementTree.Element, trajectory: Trajectory, file: str) -> None:
    """Append a trajectory to its group."""
    tag = CASPR_SPLINES[trajectory.spline]
    if trajectory.spline == "samples":
        element(group, tag, id=trajectory.name, filename=file)
        return
    definition, times = _times(trajectory)
    blend = trajectory.points[-1].blend_time
    blended = {"blend_time_default": numbers([blend])} if blend else {}
    node = element(
        group,
        tag,
        id=trajectory.name,
        time_definition=definition,
        time_step=numbers([trajectory.time_step]),
        **blended,
    )
    points = element(node, "points")
    for i, (point, time) in enumerate(zip(trajectory.points, times, strict=True)):
        attributes = {"time": numbers([time])} if i else {}
        if i and point.blend_time != blend:
            attributes["blend_time"] = numbers([point.blend_time])
        item = element(points, "point", None, **attributes)
        _values(item, point, "q" if trajectory.space == "joint" else "y")


def _values(item: ElementTree.Element, point: TrajectoryPoint, letter: str) -> None:
    for ending, values in (("", point.q), ("_dot", point.qd), ("_ddot", point.qdd)):
        if values:
            element(item, letter + ending, numbers(values))


def _times(trajectory: Trajectory) -> tuple[str, list[float]]:
    """Return relative times, as in CASPR's models, or absolute times if rounding changes them."""
    times = [point.time for point in trajectory.points]
    steps = [0.0, *(end - start for start, end in pairwise(times))]
    return ("relative", steps) if list(accumulate(steps)) == times else ("absolute", times)


def traj_file(name: str, number: int) -> str:
    """Return the name of the sample file of a trajectory of a robot."""
    return f"{name}_{number}.traj"


def traj_text(trajectory: Trajectory) -> str:
    """Return the text of a .traj file: the time step, then one sample per line."""
    lines = [f"time_step,{trajectory.time_step!r}"]
    for point in trajectory.points:
        rows = (("t", (point.time,)), ("p", point.q), ("v", point.qd), ("a", point.qdd))
        lines.append(",".join(f"{word},{','.join(map(repr, values))}" for word, values in rows))
    return "\n".join(lines)
