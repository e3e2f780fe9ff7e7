"""Names of construction points that specify their use, as in designs of earlier add-ins.

`VP_motor3_EXPORT_upper_arm_12` is via point 12 of muscle `motor3`, fixed to link `upper_arm`.
`EE_<link>` is a task point and `VM_<link>` a marker. `COM_<link>` is the origin of link coordinates
in old designs. Fusion appends ` (1)` to a name that exists already.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

NameRole = Literal["via", "task", "marker", "com"]

_MOTOR = re.compile(r"motor(0|[1-9][0-9]{0,8})", re.ASCII)
# The pattern of the link is greedy: `a_0_3` is point 3 of link `a_0`.
_VIA = re.compile(
    r"VP_motor(?P<motor>[0-9]{1,9})_EXPORT_(?P<link>.+)_(?P<number>[0-9]{1,9})"
    r"(?: ?\((?P<copy>[0-9]{1,9})\))?",
    re.ASCII | re.DOTALL,
)
_OTHER = re.compile(
    r"(?P<kind>EE|VM|COM)_(?:EXPORT_)?(?P<link>.+?)(?: ?\((?P<copy>[0-9]{1,9})\))?",
    re.ASCII | re.DOTALL,
)
_ROLES: dict[str, NameRole] = {"EE": "task", "VM": "marker", "COM": "com"}
_PREFIXES = ("VP_", "EE_", "VM_", "COM_")


@dataclass(frozen=True, slots=True)
class PointName:
    """Parsed name of a construction point.

    Attributes:
        role: `via`, `task`, `marker`, or `com`, which is ignored.
        motor: Number in the name of the muscle, for a via point.
        number: Position in the sequence of points along the muscle, for a via point.
        copy: Number that Fusion appended to a duplicate name; 0 if the name is unique.
    """

    role: NameRole
    link: str
    motor: int = 0
    number: int = 0
    copy: int = 0

    @property
    def muscle(self) -> str:
        """Name of the muscle; empty unless it is a via point."""
        return f"motor{self.motor}" if self.role == "via" else ""


def is_point_name(name: str) -> bool:
    """Return whether a name has a prefix of the add-in; it may still be malformed."""
    return name.startswith(_PREFIXES)


def parse_point_name(name: str) -> PointName | None:
    """Return the parsed name; None if it is malformed or does not belong to the add-in."""
    via = _VIA.fullmatch(name)
    if via:
        motor, number, copy = (int(via[key] or 0) for key in ("motor", "number", "copy"))
        return PointName("via", via["link"], motor, number, copy)
    other = _OTHER.fullmatch(name)
    if other:
        return PointName(_ROLES[other["kind"]], other["link"], copy=int(other["copy"] or 0))
    return None


def via_point_name(motor: int, link: str, number: int) -> str:
    """Return the name of a via point."""
    return f"VP_motor{motor}_EXPORT_{link}_{number}"


def task_point_name(link: str) -> str:
    """Return the name of a link's task point."""
    return f"EE_{link}"


def marker_name(link: str) -> str:
    """Return the name of a link's marker."""
    return f"VM_{link}"


def motor_numbers(muscles: Iterable[str]) -> dict[str, int]:
    """Return the number used in point names, for each muscle.

    `motorN` has the number N. Each of the other muscles has the smallest unused number, in order.
    """
    names = list(dict.fromkeys(muscles))
    motors = {name: int(match[1]) for name in names if (match := _MOTOR.fullmatch(name))}
    used = set(motors.values())
    free = (number for number in range(len(names) + len(used)) if number not in used)
    return {name: motors[name] if name in motors else next(free) for name in names}


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Return a sort key that compares numbers in names as numbers: `motor2` before `motor10`."""
    return tuple(_place(part) for part in re.split(r"([0-9]+)", name) if part)


def _place(part: str) -> tuple[int, int, str]:
    if not "0" <= part[0] <= "9":
        return 0, 0, part
    digits = part.lstrip("0")
    return 1, len(digits), digits
