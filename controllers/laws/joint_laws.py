"""The native laws in joint space: THE table. Their formulas are `csrc/laws/joint/<name>.c`.

Experiments, `JointSpaceController` and the documentation read the table; hatch_build.py makes of it
the list of laws in C. It reads this module by its path, so that it needs the standard library only.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

TABLE = "controllers/laws/joint_laws.py"
CSRC = "controllers/csrc/laws/joint"
C_LIST = "controllers/generated/joint_law_list.h"


class JointLaw(NamedTuple):
    """A formula for the torque of the joints, which is distributed over the muscles.

    Attributes:
        name: Its name in experiments and that of its C file, with the function `<name>_torque`.
        meaning: What it is, in Markdown.
        torque_gains: Whether its gains make torques of errors, in [N·m/rad] and [N·m·s/rad], and
            not accelerations, in [1/s²] and [1/s].
        needs_gravity: Whether it needs the array G, which costs time.
        unread: What it does not read of the reference: `qd_d`, `qdd_d`.
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
    """Return the text of `C_LIST`.

    Args:
        root: The source tree.

    Raises:
        ValueError: A law has no C file, or a C file no law.
    """
    files, names = (
        {path.stem for path in (root / CSRC).glob("*.c")},
        [law.name for law in JOINT_LAWS],
    )
    for name in sorted(files.symmetric_difference(names)):
        lacking = f"{TABLE} has no law" if name in files else f"{CSRC} has no file for the law"
        raise ValueError(f"{lacking} {name!r}")
    lines = (f"    JOINT_LAW({law.name}, {law.needs_gravity:d})" for law in JOINT_LAWS)
    head = f"/* Made by hatch_build.py of {TABLE}: change that, not this. */\n"
    return " \\\n".join([f"{head}#define JOINT_LAWS(JOINT_LAW)", *lines]) + "\n"
