"""Example contents of the add-in's dialogs, which `make_addin_page.py` draws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from addin_sdfusion.commands.check.dialog import ICONS
from addin_sdfusion.commands.define_muscles.tabs.muscles import OF_PART
from addin_sdfusion.commands.define_muscles.tabs.others import MARKER, TASK
from addin_sdfusion.commands.export.dialog import AS_ALL, FOUND, LINKS


@dataclass(frozen=True, slots=True)
class Example:
    """Example contents of a dialog.

    Attributes:
        values: Values of inputs, by id.
        cells: Rows of tables, by id.
        choices: Whether each column of a table is a drop-down, by id.
        selected: Index of the selected row of a table, by id.
        hidden: Ids of inputs that are not shown.
        icons: Icons that replace texts in tables, by id, as folders below `commands`.
    """

    values: Mapping[str, str | float | bool] = field(default_factory=dict)
    cells: Mapping[str, tuple[tuple[str, ...], ...]] = field(default_factory=dict)
    choices: Mapping[str, tuple[bool, ...]] = field(default_factory=dict)
    selected: Mapping[str, int] = field(default_factory=dict)
    hidden: tuple[str, ...] = ()
    icons: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


DEFINE = Example(
    values={
        "muscle": "biceps_l",
        "link": OF_PART,
        "length": "3 points, 411.7 mm",
        "preview": "Lines behind bodies are paler.",
        "muscle_name": "biceps_l",
        "palette": "Red",
        "color": "#d62728",
        "f_min": 10.0,
        "f_max": 250.0,
        "model": "elastic_cable",
        "wrap": "elbow_l",
        "wrap_name": "elbow_l",
        "wrap_link": "upper_arm_l",
        "mirror_all": True,
        "motion_joint": "elbow_l",
        "motion_percent": 50.0,
        "motion_at": "70.0° of 0.0° to 140.0°",
        "status": "Point 2 of biceps_l is on link forearm_l.",
    },
    cells={
        "points": (
            ("0", "torso", "-40.0, 182.0, 1320.0"),
            ("1", "upper_arm_l", "-31.5, 205.0, 1096.5"),
            ("2", "forearm_l", "-22.0, 211.0, 910.0"),
        ),
        "parameters": (
            ("stiffness", "30000", "N/m: k"),
            ("damping", "", "N.s/m, 0: d"),
            ("longest_rest_length", "", "m, 1000: largest command"),
        ),
        "all": (
            ("biceps_l", "10", "250", "elastic_cable", "3, 411.7 mm"),
            ("triceps_l", "10", "250", "ideal", "4, 388.2 mm"),
        ),
        "wrap_uses": (("biceps_l", "1", "Shorter path", "0"), ("triceps_l", "0", "Turning +", "0")),
        "motion": (
            ("■ biceps_l", "378.4 mm", "-33.3", "34.1", "▂▃▄▅▆▇███▇▆▅▃ 17.2 to 38.9"),
            ("■ triceps_l", "412.0 mm", "+23.8", "-21.0", "▁▁▁▁▁▁▁▁▁▁▁▁▁ -21.0 to -21.0"),
        ),
        "others": ((TASK, "hand_l", "hand_l"), (MARKER, "elbow_led", "forearm_l")),
    },
    choices={
        "points": (False, True, False),
        "all": (False, False, False, True, False),
        "wrap_uses": (True, False, True, False),
        "others": (False, False, True),
    },
    selected={"points": 2, "others": 0},
)

CHECK = Example(
    values={
        "summary": "1 error, 2 warnings. Errors must be fixed before the export.",
        "detail": "muscle biceps_l: point 2 is on link forearm_L, which does not exist; did you "
        "mean 'forearm_l'? Choose the link in Define muscles.",
    },
    cells={
        "findings": (
            ("error", "muscle biceps_l", "point 2 is on link forearm_L, which does not exist"),
            ("warning", "joint wrist_l", "has limits 0 to 0 and cannot move"),
            ("warning", "body Cover", "does not belong to a rigid group and is not exported"),
        )
    },
    selected={"findings": 0},
    icons={"findings": {name: f"check/resources/{icon}" for name, icon in ICONS.items()}},
)

EXPORT = Example(
    values={
        "name": "msj",
        "folder": "C:\\Users\\me\\robots\\msj",
        "links": next(iter(LINKS)),
        "base": FOUND,
        "fixed_base": True,
        "cut_joints": "pedal_r",
        "up_axis": "z",
        "visual": True,
        "collision": "Convex hull",
        "quality": "Normal",
        "caspr": True,
        "osim": True,
        "urdf": True,
        "status": "No errors, 1 warning: joint 'wrist_l' has limits 0 to 0 and cannot move.\n"
        "Since the last export:\nlink forearm_l: 0.85 kg; before: 0.912 kg",
    },
    cells={
        "of_links": (("torso", AS_ALL, "", ""), ("forearm_l", "Cylinder", "0.85", "ulna")),
        "of_joints": (
            ("shoulder_l", "25", "0.1", "", "6", "As designed"),
            ("elbow_l", "", "0.05", "0.02", "", "Reversed"),
        ),
    },
    choices={
        "of_links": (False, True, False, False),
        "of_joints": (False, False, False, False, False, True),
    },
    hidden=("components",),
)
