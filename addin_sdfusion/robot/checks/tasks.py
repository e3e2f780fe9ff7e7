"""Checks of task frames: link and axes."""

from __future__ import annotations

from collections.abc import Iterator

from ..finding import Finding, Subject
from ..finding_builders import all_task_frames, error, unknown
from ..model.robot import ANGLES, POSITIONS, Robot


def task_frames(robot: Robot) -> Iterator[Finding]:
    """Check that task frames are on existing links and name each axis once."""
    links = [link.name for link in robot.links]
    link_names = set(links)
    for task_set in robot.task_sets:
        if not task_set.frames:
            problem = "has no frames; remove it or add one"
            yield error(Subject("task_set", task_set.name), "empty-task-set", problem)
    for subject, frame in all_task_frames(robot):
        if frame.link not in link_names:
            yield error(subject, "unknown-task-link", unknown("link", frame.link, links))
        axes = set(frame.axes)
        of_one_kind = axes <= set(POSITIONS) or axes <= set(ANGLES)
        if not axes or len(axes) != len(frame.axes) or not of_one_kind:
            axes_text = f"axes {' '.join(frame.axes)!r}"
            problem = f"{axes_text}: use axes from x, y, z or from alpha, beta, gamma, each once"
            yield error(subject, "bad-task-axes", problem)
