"""Reads joint trajectories from CASPR's `<name>_trajectories.xml`."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError, UnknownNameError
from ..finding import Subject
from ..trajectory import Spline, Trajectory, TrajectoryPoint
from .xml import Node, Notes, parse, shortened

SPLINES: dict[str, tuple[Spline, tuple[str, ...]]] = {
    "linear_spline_trajectory": ("linear", ("q",)),
    "cubic_spline_trajectory": ("cubic", ("q", "q_dot")),
    "quintic_spline_trajectory": ("quintic", ("q", "q_dot", "q_ddot")),
}
"""The spline and what a point gives, by element."""


def trajectory_names(file: str | Path) -> tuple[str, ...]:
    """The names of the joint trajectories in a file, of whatever kind, in order.

    Raises:
        InputError: The file is not a readable trajectory file.
    """
    return tuple(node.attribute("id", "") for node in _nodes(Path(file), Notes()))


def read_trajectory(file: str | Path, name: str) -> Trajectory:
    """Read one joint trajectory.

    Args:
        file: A trajectory file.
        name: Its id in the file.

    Raises:
        UnknownNameError: The file has no such joint trajectory.
        InputError: The file or the trajectory cannot be used.
    """
    file, notes = Path(file), Notes()
    nodes = _nodes(file, notes)
    found = [node for node in nodes if node.attribute("id", "") == name]
    if not found:
        known = [node.attribute("id", "") for node in nodes]
        raise UnknownNameError("joint trajectory", name, known, file=file)
    if len(found) > 1:
        what = f"a second trajectory {name!r}; rename it"
        raise InputError(what, file=file, line=found[1].line)
    trajectory = _trajectory(found[0].about(Subject("trajectory", name)))
    for finding in notes.findings:
        raise InputError(finding.message, file=finding.file, line=finding.line)
    return trajectory


def _nodes(file: Path, notes: Notes) -> list[Node]:
    root = parse(file, Subject("trajectory", ""), notes)
    if root.tag != "trajectories":
        what = f"<{root.tag}> is not CASPR's <trajectories>"
        raise InputError(what, file=file, line=root.line)
    return [node for group in root.all("joint_trajectories") for node in group.all()]


def _trajectory(node: Node) -> Trajectory:
    if node.tag not in SPLINES:
        what = f"trajectory {node.subject.name!r}: <{node.tag}> is not supported"
        known = ", ".join(SPLINES)
        raise InputError(f"{what} (supported: {known})", file=node.file, line=node.line)
    spline, tags = SPLINES[node.tag]
    time_step = node.number_attribute("time_step")
    if node.has("time_step") and time_step <= 0.0:
        node.error("bad-time", "time_step is not above zero")
    return Trajectory(node.subject.name, spline, _points(node, tags), time_step)


def _points(node: Node, tags: tuple[str, ...]) -> tuple[TrajectoryPoint, ...]:
    definition = node.attribute("time_definition")
    if definition not in ("relative", "absolute"):
        problem = f"time_definition {shortened(definition)} is neither 'relative' nor 'absolute'"
        node.error("bad-time", problem)
    group = node.required("points")
    items = group.all("point") if group else []
    if len(items) < 2:
        node.error("too-few-points", f"needs two points at least, has {len(items)}")
        return ()
    first = items[0].optional("q")
    size = max(1, len(first.text.split())) if first else 1
    points: list[TrajectoryPoint] = []
    for item in items:
        before = points[-1].time if points else None
        values = [_vector(item, tag, size) for tag in tags]
        points.append(TrajectoryPoint(_time(item, before, definition), *values))
    return tuple(points)


def _vector(point: Node, tag: str, size: int) -> tuple[float, ...]:
    node = point.required(tag)
    return node.numbers(size) if node else ()


def _time(point: Node, before: float | None, definition: str) -> float:
    """The absolute time of a point; whatever the file says, the first is at 0."""
    if before is None:
        return 0.0
    time = point.number_attribute("time") + (before if definition == "relative" else 0.0)
    if point.has("time") and not time > before:
        point.error("bad-time", f"time {time!r} s does not come after {before!r} s")
    return time
