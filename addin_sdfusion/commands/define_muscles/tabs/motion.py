"""Tab Motion of the dialog: lengths and moment arms of the muscles while a joint moves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ....building.build_robot import moving_robot
from ....muscles.motion import JointSweep, arm_color
from ....muscles.table import MuscleTable
from ....robot.model.robot import Robot
from ....snapshot import DesignSnapshot
from ...dialogs import Cell, Input
from ..model.model import MuscleModel

if TYPE_CHECKING:
    from ...inputs import Inputs

NO_JOINT = "(no moving joints)"

TAB = Input(
    "tab_motion",
    "tab",
    "Motion",
    children=(
        Input("motion_joint", "dropdown", "Joint", "The joint that moves.", options=(NO_JOINT,)),
        Input(
            "motion_percent",
            "slider",
            "Position [%]",
            "Position in the range of the joint: 0 is its lower limit, 100 its upper limit. Parts "
            "of the design do not move.",
        ),
        Input("motion_at", "text", "Position", "Position and range of the joint."),
        Input(
            "motion",
            "table",
            "Muscles",
            "Length of each muscle at this position, its change since the pose of the design, and "
            "its moment arm: torque at the joint per unit of muscle force. Here and in the canvas, "
            "muscles with a positive moment arm are red, with a negative one blue.",
            columns=("Muscle", "Length", "Change [mm]", "Arm [mm]", "Arm over the range [mm]"),
            widths=(3, 3, 2, 2, 5),
            rows=16,
        ),
    ),
)


class MotionTab:
    """Tab Motion; the robot is built when the tab is first shown.

    Attributes:
        colors: Colours of the muscles by their moment arms, while the tab is open.
    """

    def __init__(self, snapshot: DesignSnapshot) -> None:
        self._snapshot = snapshot
        self._robot: Robot | None = None
        self._problem = ""
        self._sweep: JointSweep | None = None
        self.colors: dict[str, str] = {}

    def show(self, model: MuscleModel, inputs: Inputs) -> None:
        """Show all muscles at the chosen position of the chosen joint, if the tab is open."""
        self.colors = {}
        if not inputs["tab_motion"].isActive:
            return
        if self._robot is None and not self._problem:
            self._robot, self._problem = moving_robot(self._snapshot)
        coordinates = self._robot.coordinates if self._robot else ()
        names = tuple(c.name for c in coordinates) or (NO_JOINT,)
        chosen = inputs.value("motion_joint")
        inputs.choose("motion_joint", names, chosen if chosen in names else names[0])
        name = inputs.value("motion_joint")
        coordinate = next((c for c in coordinates if c.name == name), None)
        if self._robot is None or coordinate is None:
            inputs.set("motion_at", self._problem or "No joint of the design moves.")
            inputs.fill("motion", [])
            return
        if self._sweep is None or self._sweep.coordinate != coordinate:
            self._sweep = JointSweep(self._robot, coordinate)
            low, high = self._sweep.range()
            share = (coordinate.initial - low) / (high - low) if high > low else 0.0
            inputs.set("motion_percent", 100.0 * min(max(share, 0.0), 1.0))
        self._fill(inputs, model.table, self._sweep)

    def _fill(self, inputs: Inputs, table: MuscleTable, sweep: JointSweep) -> None:
        low, high = sweep.range()
        q = low + (high - low) * min(float(inputs.value("motion_percent")), 100.0) / 100.0
        turns = sweep.coordinate.unit == "rad"
        scale, unit = (180.0 / math.pi, "°") if turns else (1000.0, " mm")
        where = f"{scale * q:.1f}{unit} of {scale * low:.1f}{unit} to {scale * high:.1f}{unit}"
        if sweep.robot.loops:
            where += "; closed loops are open while the joint moves"
        inputs.set("motion_at", where)
        motions = {row.name: sweep.muscle(table, row.name, q) for row in table.rows}
        largest = max((abs(at.arm) for at in motions.values()), default=0.0)
        self.colors = {name: arm_color(at.arm, largest) for name, at in motions.items()}
        rows = []
        for name, at in motions.items():
            low_arm, high_arm = min(at.arms), max(at.arms)
            plot = f"{at.plot} {_arm(low_arm, turns)} to {_arm(high_arm, turns)}"
            change = f"{1000.0 * at.change:+.1f}"
            texts = (at.path.length_text, change, _arm(at.arm, turns), plot)
            shown = Cell(name, lines=1, color=self.colors[name])
            rows.append([shown, *(Cell(text) for text in texts)])
        inputs.fill("motion", rows)


def _arm(arm: float, turns: bool) -> str:
    """Return a moment arm in [mm], or without unit for a sliding joint."""
    text = f"{1000.0 * arm:.1f}" if turns else f"{arm:.3f}"
    return text if float(text) else text.lstrip("-")
