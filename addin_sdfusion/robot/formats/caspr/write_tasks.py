"""Conversion of task frames to items of CASPR's operational spaces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ...caspr_vocabulary import CASPR_AXES, ORIENTATION
from ...model.pose import Vector3
from ...model.robot import TaskFrame


class TaskItem(NamedTuple):
    """Item of an operational space.

    Attributes:
        offset: Point on the link, in [m]; None for an orientation.
        letters: Letters of its axes.
    """

    tag: str
    name: str
    link: str
    offset: Vector3 | None
    letters: str


def task_items(frames: Sequence[TaskFrame]) -> Iterator[TaskItem]:
    """Yield positions, orientations, and poses if an orientation follows its position."""
    i = 0
    while i < len(frames):
        frame = frames[i]
        letters = _letters(frame)
        i += 1
        if frame.is_orientation:
            yield TaskItem("orientation_euler_xyz", frame.name, frame.link, None, letters)
        elif i < len(frames) and _form_pose(frame, frames[i]):
            letters += _letters(frames[i])
            i += 1
            yield TaskItem("pose_euler_xyz", frame.name, frame.link, frame.position, letters)
        else:
            yield TaskItem("position", frame.name, frame.link, frame.position, letters)


def _form_pose(first: TaskFrame, second: TaskFrame) -> bool:
    """Return whether a position and the next frame form one pose."""
    same = first.link == second.link and second.name == first.name + ORIENTATION
    return same and second.is_orientation


def _letters(frame: TaskFrame) -> str:
    letters = {axis: letter for letter, axis in CASPR_AXES.items()}
    return "".join(letters[axis] for axis in frame.axes)
