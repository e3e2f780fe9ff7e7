"""Table of the native control laws in joint space.

The file `csrc/laws/joint/<name>.c` implements the formula of a law. Experiments,
`JointSpaceController` and the documentation read this table, and hatch_build.py generates the list
of laws in C from it. This module only uses the standard library, since hatch_build.py loads it by
its path.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

TABLE = "controllers/laws/joint_laws.py"
CSRC = "controllers/csrc/laws/joint"
C_LIST = "controllers/generated/joint_law_list.h"


class JointLaw(NamedTuple):
    """Control law with a formula for the joint torque, which is distributed over the muscles.

    Attributes:
        name: Name in experiments, of the C file, and of the function `<name>_torque` in it.
        meaning: Description in Markdown.
        torque_gains: Whether the gains convert errors to torques, in [N·m/rad] and [N·m·s/rad],
            instead of accelerations, in [1/s²] and [1/s].
        needs_gravity: Whether the law uses the array G. Other laws save its computation.
        unread: Parts of the reference that the law does not use: `qd_d`, `qdd_d`.
    """

    name: str
    meaning: str
    torque_gains: bool = False
    needs_gravity: bool = False
    unread: tuple[str, ...] = ()


JOINT_LAWS = (
    JointLaw(
        "joint_space", "computed torque, [eq. (3)](../explanation/equations.md#joint-space-eq-3)"
    ),
    JointLaw(
        "force_position",
        "computed torque without the reference's acceleration",
        unread=("qdd_d",),
    ),
    JointLaw(
        "torque_position",
        "a spring and a damper at every joint",
        torque_gains=True,
        unread=("qd_d", "qdd_d"),
    ),
    JointLaw(
        "lyapunov",
        "a spring, a damper and the robot's weight",
        torque_gains=True,
        needs_gravity=True,
        unread=("qdd_d",),
    ),
)


def c_list(root: Path) -> str:
    """Return the contents of `C_LIST`.

    Args:
        root: Root folder of the source tree.

    Raises:
        ValueError: A law has no C file, or a C file is not in the table.
    """
    files, names = (
        {path.stem for path in (root / CSRC).glob("*.c")},
        [law.name for law in JOINT_LAWS],
    )
    for name in sorted(files.symmetric_difference(names)):
        missing = f"{TABLE} has no law" if name in files else f"{CSRC} has no file for the law"
        raise ValueError(f"{missing} {name!r}")
    lines = (f"    JOINT_LAW({law.name}, {law.needs_gravity:d})" for law in JOINT_LAWS)
    head = f"/* Made by hatch_build.py of {TABLE}: change that, not this. */\n"
    return " \\\n".join([f"{head}#define JOINT_LAWS(JOINT_LAW)", *lines]) + "\n"
