"""Writes muscles and end effectors as cardsflow.xml has them.

A muscle names its links in order, each with the via points on it, in the frame of that link. The
attributes `f_min` and `f_max` of a muscle and `axes` of an end effector go beyond the original
format; readers that do not know them pass them over.
"""

from __future__ import annotations

from itertools import groupby
from xml.etree import ElementTree

from .model import Robot, TaskFrame
from .muscle import Muscle
from .xml_text import document, element, numbers


def muscle_element(parent: ElementTree.Element, muscle: Muscle) -> None:
    """Add `<myoMuscle name f_min f_max>` to its parent."""
    limits = {"f_min": numbers([muscle.f_min]), "f_max": numbers([muscle.f_max])}
    node = element(parent, "myoMuscle", name=muscle.name, **limits)
    for link, points in groupby(muscle.via_points, key=lambda point: point.link):
        block = element(node, "link", name=link)
        for point in points:
            element(block, "viaPoint", numbers(point.position), type="FIXPOINT")


def end_effector_element(parent: ElementTree.Element, frame: TaskFrame) -> None:
    """Add `<endEffector name link axes>` to its parent."""
    text = numbers(frame.position)
    axes = "".join(frame.axes)
    element(parent, "endEffector", text, name=frame.name, link=frame.link, axes=axes)


def cardsflow_xml(robot: Robot) -> str:
    """The text of a cardsflow.xml: the active muscles and task frames of a robot."""
    root = element(None, "cardsflow")
    for muscle in robot.muscles:
        muscle_element(root, muscle)
    for frame in robot.task_frames:
        end_effector_element(root, frame)
    return document(root)
