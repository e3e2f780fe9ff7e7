"""The controllers that an experiment may ask for: by the name of their type, or one's own."""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple, Self, get_args

from addin_sdfusion.robot import InputError, UnknownNameError, limits
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.model.trajectory import Space
from controllers.laws.operational_space import FORCE_WEIGHT
from controllers.laws.reactive_qp import TASK_WEIGHT

LawName = Literal[
    "joint_space",
    "force_position",
    "torque_position",
    "lyapunov",
    "operational_space",
    "reactive_qp",
]


@dataclass(frozen=True, slots=True)
class ControlType:
    """A type of controller.

    Attributes:
        law: Its class in `controllers`.
        space: What it follows: joint positions, or task coordinates.
        torque_gains: Whether its gains make torques of errors, instead of accelerations.
        unread: What of the reference the law does not read, by the first part of its names.
        force_weight: Default of the weights of the muscles, in [1/N²].
        task_weight: Default of the weights of tasks; None if they are to be met exactly.
    """

    law: str
    space: Space
    torque_gains: bool = False
    unread: tuple[str, ...] = ()
    force_weight: float = 1.0
    task_weight: float | None = None


TYPES: dict[LawName, ControlType] = {
    "joint_space": ControlType("JointSpaceController", "joint"),
    "force_position": ControlType("ForcePositionController", "joint", unread=("qdd_d",)),
    "torque_position": ControlType(
        "TorquePositionController", "joint", torque_gains=True, unread=("qd_d", "qdd_d")
    ),
    "lyapunov": ControlType("LyapunovController", "joint", torque_gains=True, unread=("qdd_d",)),
    "operational_space": ControlType(
        "OperationalSpaceController", "operational", force_weight=FORCE_WEIGHT
    ),
    "reactive_qp": ControlType(
        "ReactiveQPController",
        "operational",
        force_weight=FORCE_WEIGHT,
        task_weight=TASK_WEIGHT,
    ),
}


_OWN_LAW = re.compile(r"(?P<file>.+\.py):(?P<name>[^\W\d]\w*)", re.DOTALL)
OWN_LAW_FORM = "<file>.py:<class>"


class OwnLaw(NamedTuple):
    """A controller of one's own: a class in a file of Python.

    Attributes:
        file: The file.
        name: The class.
    """

    file: Path
    name: str

    @classmethod
    def of(cls, law: str) -> Self | None:
        """From the type of a controller; None where that is the name of one of ours."""
        match = _OWN_LAW.fullmatch(law)
        return None if match is None else cls(Path(match["file"]), match["name"])

    def __str__(self) -> str:
        return f"{self.file.as_posix()}:{self.name}"

    def require(self) -> None:
        """Refuse what is no class in a file of Python; nothing of the file is run.

        Raises:
            InputError: The file cannot be read, is not Python, or does not have the class.
        """
        try:
            tree = ast.parse(read_file(self.file, limits.CODE))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            line = error.lineno if isinstance(error, SyntaxError) else None
            what = f"cannot be read: {getattr(error, 'msg', error)}"
            raise InputError(what, file=self.file, line=line) from None
        classes = [node.name for node in tree.body if isinstance(node, ast.ClassDef)]
        if self.name not in classes:
            raise UnknownNameError("class", self.name, classes, file=self.file)


def require_law(law: str) -> None:
    """Refuse what is neither the name of a law nor of the form of one's own.

    Raises:
        UnknownNameError: It is none.
    """
    if law not in TYPES and OwnLaw.of(law) is None:
        raise UnknownNameError("controller type", law, [*get_args(LawName), OWN_LAW_FORM])


def control_type(law: str, space: Space | None = None) -> ControlType:
    """What is known of a law.

    Args:
        law: The name of one of ours, or one's own.
        space: What one's own follows.
    """
    return TYPES.get(law) or ControlType(law, space or "joint")  # type: ignore[call-overload]
