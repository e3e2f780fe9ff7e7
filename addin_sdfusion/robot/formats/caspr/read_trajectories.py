"""Reader of `<name>_trajectories.xml` of CASPR and the .traj files next to it."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path, PurePosixPath

from ...caspr_vocabulary import CASPR_DERIVATIVES, CASPR_SPLINES
from ...errors import InputError, UnknownNameError
from ...finding import Finding, Subject
from ...finding_builders import label
from ...limits import MIB, TRAJECTORY
from ...mesh_files import lies_in
from ...model.trajectory import Space, Spline, Trajectory, TrajectoryPoint
from ..reading.xml import Node, Notes, parse, short_repr
from .read import BODIES
from .traj_file import read_samples

AVERAGE = "cubic_spline_average_velocity_trajectory"
"""Cubic spline whose inner velocities are the mean of the slopes before and after."""

SPLINES: dict[str, Spline] = {tag: spline for spline, tag in CASPR_SPLINES.items()}
SPLINES[AVERAGE] = "cubic"
TOO_MANY = f"the .traj files exceed {TRAJECTORY // MIB} MiB in total"
_OUTSIDE = "is a link to a file outside this folder"
LETTERS: dict[Space, str] = {"joint": "q", "operational": "y"}


def trajectories_file(bodies: Path) -> Path | None:
    """Return the trajectories file next to a `<name>_bodies.xml`, or None if it does not exist.

    Raises:
        InputError: The file is a link to a file outside the folder.
    """
    stem = bodies.name.removesuffix(BODIES)
    file = bodies.with_name(f"{stem}_trajectories.xml")
    if stem == bodies.name or not file.is_file():
        return None
    if not lies_in(file, [bodies.parent]):
        raise InputError(f"{_OUTSIDE}; copy the file here", file=file)
    return file


def trajectory_names(file: str | Path, space: Space = "joint") -> tuple[str, ...]:
    """Return the names of the trajectories of a space, of any type, in order."""
    return tuple(node.attribute("id", "") for node in _nodes(Path(file), Notes())[space])


def read_trajectory(file: str | Path, name: str, space: Space = "joint") -> Trajectory:
    """Read one trajectory.

    CASPR computes the inner velocities of some splines as mean slopes. They are computed here, so
    that the result is a cubic spline. The times are the times of the points. If the time step does
    not divide a segment, CASPR ends the segment at the last step before the point; here it ends at
    the point.
    """
    file, notes = Path(file), Notes()
    return _valid_trajectory(_find_element(_nodes(file, notes), name, space, file), space, notes)


def read_trajectories(robot: str | Path) -> tuple[list[Trajectory], list[Finding]]:
    """Read all trajectories next to a robot.

    Args:
        robot: Main file of the robot; only CASPR files have trajectories.

    Returns:
        The trajectories in order, joint space first, and a warning for each invalid trajectory or
        for the whole file. If two trajectories have the same name, the first one is returned, since
        CASPR loads only one.
    """
    notes, findings = Notes(), []
    trajectories: dict[str, Trajectory] = {}
    remaining = TRAJECTORY
    try:
        file = trajectories_file(Path(robot))
        groups = {} if file is None else _nodes(file, notes)
    except InputError as error:
        groups = {}
        findings.append(_ignored("", error))
    for space, nodes in groups.items():
        for node in nodes:
            name = node.attribute("id", "")
            try:
                if name in trajectories:
                    problem = "another trajectory has this name; rename it"
                    raise InputError(problem, file=node.file, line=node.line)
                if SPLINES.get(node.tag) == "samples":
                    remaining -= _samples_file(node).stat().st_size
                if remaining < 0:
                    raise InputError(TOO_MANY, file=node.file, line=node.line)
                trajectories[name] = _valid_trajectory(node, space, notes)
            except InputError as error:
                findings.append(_ignored(name, error))
                notes.findings.clear()
    return list(trajectories.values()), findings


def _ignored(name: str, error: InputError) -> Finding:
    """Return the finding that a trajectory, or the whole file, is ignored."""
    subject = Subject("trajectory", name)
    problem = error.problem.removeprefix(f"{label(subject)}: ")
    message = f"{problem}; its trajectories are ignored"
    if name:
        message = f"{label(subject)}: {problem}; omitted"
    return Finding("warning", "trajectory-left-out", message, subject, error.file, error.line)


def _valid_trajectory(node: Node, space: Space, notes: Notes) -> Trajectory:
    """Return the trajectory of an element; raise InputError on its first error."""
    trajectory = _trajectory(
        node.with_subject(Subject("trajectory", node.attribute("id", ""))), space
    )
    for finding in notes.findings:
        raise InputError(finding.message, file=finding.file, line=finding.line)
    return trajectory


def _nodes(file: Path, notes: Notes) -> dict[Space, list[Node]]:
    root = parse(file, Subject("trajectory", ""), notes)
    if root.tag != "trajectories":
        problem = f"<{root.tag}> is not CASPR's <trajectories>"
        raise InputError(problem, file=file, line=root.line)
    return {
        space: [node for group in root.all(f"{space}_trajectories") for node in group.all()]
        for space in LETTERS
    }


def _find_element(groups: dict[Space, list[Node]], name: str, space: Space, file: Path) -> Node:
    """Return the only element with this name and space."""
    elements_of = {
        key: [node for node in nodes if node.attribute("id", "") == name]
        for key, nodes in groups.items()
    }
    matching = elements_of.pop(space)
    if len(matching) > 1:
        problem = f"trajectory {name!r} appears twice; rename one of them"
        raise InputError(problem, file=file, line=matching[1].line)
    if matching:
        return matching[0]
    for other, nodes in elements_of.items():
        if nodes:
            problem = f"trajectory {name!r} is in {other} space, not in {space} space"
            raise InputError(problem, file=file, line=nodes[0].line)
    names = [node.attribute("id", "") for node in groups[space]]
    raise UnknownNameError(f"{space} trajectory", name, names, file=file)


def _trajectory(node: Node, space: Space) -> Trajectory:
    name = node.subject.name
    if node.tag not in SPLINES:
        problem = f"trajectory {name!r}: unsupported <{node.tag}>"
        choices = ", ".join(SPLINES)
        raise InputError(f"{problem}; known: {choices}", file=node.file, line=node.line)
    spline = SPLINES[node.tag]
    if spline == "samples":
        time_step, points = read_samples(_samples_file(node))
        return Trajectory(name, spline, points, time_step, space)
    time_step = node.number_attribute("time_step")
    if node.has("time_step") and time_step <= 0.0:
        node.error("bad-time", "time_step must be positive")
    points = _points(node, spline, LETTERS[space])
    return Trajectory(name, spline, points, time_step, space)


def _samples_file(node: Node) -> Path:
    """Return the .traj file of an element, which must be in the folder of its file or below."""
    name = node.attribute("filename")
    path = PurePosixPath(name.replace("\\", "/"))
    if not path.name or path.is_absolute() or ".." in path.parts or "\0" in name:
        problem = f"filename {short_repr(name)} must be relative to this folder, without '..'"
        raise InputError(problem, file=node.file, line=node.line)
    file = node.file.parent / path
    if not file.is_file():
        problem = f"trajectory {node.subject.name!r}: file {name!r} does not exist"
        raise InputError(problem, file=node.file, line=node.line)
    if not lies_in(file, [node.file.parent]):  # FMUs and results would contain its samples
        problem = f"trajectory {node.subject.name!r}: {name!r} {_OUTSIDE}; copy the file here"
        raise InputError(problem, file=node.file, line=node.line)
    return file


def _points(node: Node, spline: Spline, letter: str) -> tuple[TrajectoryPoint, ...]:
    definition = node.attribute("time_definition")
    if definition not in ("relative", "absolute"):
        problem = f"time_definition {short_repr(definition)} must be 'relative' or 'absolute'"
        node.error("bad-time", problem)
    group = node.required("points")
    items = group.all("point") if group else []
    if len(items) < 2:
        node.error("too-few-points", f"must have at least two points, not {len(items)}")
        return ()
    first = items[0].optional(letter)
    size = max(1, len(first.text.split())) if first else 1
    points: list[TrajectoryPoint] = []
    for i, item in enumerate(items):
        before = points[-1].time if points else None
        inner = 0 < i < len(items) - 1
        derivatives = 0 if node.tag == AVERAGE and inner else CASPR_DERIVATIVES[spline]
        tags = [letter + ending for ending in ("", "_dot", "_ddot")[: derivatives + 1]]
        q, qd, qdd = ([_vector(item, tag, size) for tag in tags] + [(), ()])[:3]
        points.append(TrajectoryPoint(_time(item, before, definition), q, qd, qdd))
    if node.tag == AVERAGE:
        return _with_means(points)
    return _with_blends(node, items, points) if spline == "parabolic_blend" else tuple(points)


def _with_means(points: list[TrajectoryPoint]) -> tuple[TrajectoryPoint, ...]:
    """Return the points with the mean slopes as velocities of the inner points."""
    segments = list(pairwise(points))
    if any(end.time <= start.time or len(end.q) != len(start.q) for start, end in segments):
        return tuple(points)  # the error is reported elsewhere
    slopes = [
        [(b - a) / (end.time - start.time) for a, b in zip(start.q, end.q, strict=True)]
        for start, end in segments
    ]
    inner = [
        replace(point, qd=tuple((a + b) / 2.0 for a, b in zip(before, after, strict=True)))
        for point, (before, after) in zip(points[1:-1], pairwise(slopes), strict=True)
    ]
    return (points[0], *inner, points[-1])


def _with_blends(
    node: Node, items: list[Node], points: list[TrajectoryPoint]
) -> tuple[TrajectoryPoint, ...]:
    """Return the points with the blend times of the segments before them."""
    if items[0].has("blend_time"):
        items[0].error(
            "bad-time", "blend_time of the first point has no segment before it; remove it"
        )
    blended = [points[0]]
    for item, (before, point) in zip(items[1:], pairwise(points), strict=True):
        is_set = item.has("blend_time")
        blend = (
            item.number_attribute("blend_time")
            if is_set
            else node.number_attribute("blend_time_default")
        )
        if not 0.0 < 2.0 * blend < point.time - before.time:
            problem = f"blend time {blend!r} s must be positive and less than half of the segment"
            item.error("bad-time", f"{problem}, {point.time - before.time!r} s")
        blended.append(replace(point, blend_time=blend))
    return tuple(blended)


def _vector(point: Node, tag: str, size: int) -> tuple[float, ...]:
    node = point.required(tag)
    return node.numbers(size) if node else ()


def _time(point: Node, before: float | None, definition: str) -> float:
    """Return the absolute time of a point; the first point is always at 0."""
    if before is None:
        return 0.0
    time = point.number_attribute("time") + (before if definition == "relative" else 0.0)
    if point.has("time") and not time > before:
        point.error("bad-time", f"time {time!r} s must be greater than {before!r} s")
    return time
