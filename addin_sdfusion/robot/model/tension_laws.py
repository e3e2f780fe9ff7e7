"""The tension laws of muscles: their parameters, commands and states, by the names files use.

This is THE table. The equations themselves are in the C core (`sim_dart/csrc/law_*.c`), which
takes the parameters in the order given here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from ..errors import InputError
from .muscle import CableModel, Muscle
from .tension_parameters import (
    DE_GROOTE,
    ELASTIC_CABLE,
    HEAVY_CABLE,
    LIGAMENT,
    MCKIBBEN,
    MILLARD,
    MOTOR,
    MUJOCO,
    PATH_SPRING,
    ROBOY_MYO_MUSCLE,
    ROBOY_TEST_BENCH,
    SCHUTTE,
    SPRING,
    TENDON_SPRING,
    THELEN,
    WINCH,
    WINCH_POSITION,
    Parameter,
)


class Command(NamedTuple):
    """What drives a muscle.

    Attributes:
        name: What it is.
        unit: Its unit, as FMI writes units.
        low: Its smallest value: a number, or the parameter that says it (`-` before: its negative).
        high: Its largest value, likewise.
    """

    name: str
    unit: str
    low: float | str
    high: float | str


class LawState(NamedTuple):
    """A number that a muscle remembers.

    Attributes:
        name: What it is; with the muscle's name a variable: `activation.biceps`.
        unit: Its unit, as FMI writes units.
        where: The parameter that must not be 0 for the muscle to have it; empty if it always has.
    """

    name: str
    unit: str
    where: str = ""


class TensionLaw(NamedTuple):
    """How the tension of a muscle follows from its command, its length and its speed.

    Attributes:
        kind: Its name in files.
        meaning: What it is, in a few words.
        source: Where the equations come from.
        parameters: Its numbers, in the C core's order.
        command: What drives it; None for a passive one.
        states: What it remembers, in order.
        stretches: Whether it stretches all along its path, so that friction in bends holds stretch.
    """

    kind: str
    meaning: str
    source: str
    parameters: tuple[Parameter, ...] = ()
    command: Command | None = None
    states: tuple[LawState, ...] = ()
    stretches: bool = False


_EXCITATION = Command("excitation", "1", 0.0, 1.0)
_DRUM_STATES = (LawState("drum_speed", "rad/s"), LawState("drum_angle", "rad"))
_HILL_STATES = (LawState("activation", "1"), LawState("fibre_length", "m", "elastic_tendon"))

TENSION_LAWS: dict[str, TensionLaw] = {
    law.kind: law
    for law in (
        TensionLaw("ideal", "a cable that pulls as commanded", "f = max(u, 0)", (),
                   Command("force", "N", 0.0, math.inf)),
        TensionLaw("elastic_cable", "a cable with stiffness and damping; slack when too long",
                   "f = k (l - u) + d l' while l > u, never below 0", ELASTIC_CABLE,
                   Command("rest_length", "m", 0.0, "longest_rest_length"), stretches=True),
        TensionLaw("passive_spring", "CASPR's spring: it pulls, and pushes when too short",
                   "CASPR, CableModelPassiveLinearSpring: f = K (l - l0)", SPRING),
        TensionLaw("series_elastic_motor", "a DC motor with gear and spindle behind a spring",
                   "Roboy's myo-motor: La i' = V - R i - Ke N w; "
                   "N J w' = Kt i - r f / (rho N); f = k (l - l0 + r theta)", MOTOR,
                   Command("voltage", "V", "-max_voltage", "max_voltage"),
                   (LawState("current", "A"), LawState("spindle_speed", "rad/s"),
                    LawState("spindle_angle", "rad"))),
        TensionLaw("mckibben", "a pneumatic muscle: a bladder in a braided sleeve",
                   "Chou & Hannaford 1996: F = p (3 L^2 - b^2) / (4 pi n^2)", MCKIBBEN,
                   Command("pressure", "Pa", 0.0, "max_pressure"), (LawState("pressure", "Pa"),)),
        TensionLaw("hill_degroote2016", "a muscle of Hill's type with smooth closed-form curves",
                   "De Groote, Kinney, Rao & Fregly 2016, Ann. Biomed. Eng. 44", DE_GROOTE,
                   _EXCITATION, _HILL_STATES),
        TensionLaw("hill_millard2012", "a muscle of Hill's type with Bezier curves and damping",
                   "Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135", MILLARD,
                   _EXCITATION, _HILL_STATES),
        TensionLaw("hill_thelen2003", "a muscle of Hill's type with Thelen's curves",
                   "Thelen 2003, J. Biomech. Eng. 125", THELEN, _EXCITATION, _HILL_STATES),
        TensionLaw("hill_schutte1993", "a muscle of Hill's type with curves through points",
                   "Schutte, Rodgers, Zajac & Glaser 1993, IEEE Trans. Rehabil. Eng. 1; curves of "
                   "OpenSim's model of the wrist", SCHUTTE, _EXCITATION, _HILL_STATES),
        TensionLaw("ligament_blankevoort1991", "a ligament: a toe, then a line; damped when pulled",
                   "Blankevoort, Kuiper, Huiskes & Grootenboer 1991, J. Biomech. 24", LIGAMENT),
        TensionLaw("mujoco_muscle", "MuJoCo's muscle, of Hill's type with a rigid tendon",
                   "MuJoCo: f = F (FL(L) FV(V) a + FP(L))", MUJOCO,
                   Command("excitation", "1", "control_low", "control_high"),
                   (LawState("activation", "1"),)),
        TensionLaw("path_spring", "OpenSim's spring along a path, slack when too short",
                   "OpenSim, PathSpring: f = K (l - l0) (1 + D l'), never below 0", PATH_SPRING,
                   stretches=True),
        TensionLaw("tendon_spring", "a spring and damper of MuJoCo's tendons; it pushes, too",
                   "MuJoCo: f = k (l - l_high) or k (l - l_low), + d l'", TENDON_SPRING),
        TensionLaw("winch", "a motor with gear and drum that winds up an elastic cable",
                   "(N^2 J_M + J_D) w' = N u - r (f + EA e^2 / 2) - b w - Tc sgn w; f = EA e "
                   "(1 + D e'), never below 0, e = (l - l_u) / (l_u + l_lead); l_u = l_0 - r "
                   "theta. A drum takes up strain energy as well, EA e^2 / 2 a length", WINCH,
                   Command("torque", "N.m", "-max_torque", "max_torque"), _DRUM_STATES, True),
        TensionLaw("winch_position", "the same with a drive that holds the length of cable",
                   "winch, with N u = Kp (l_u - u) / r - Kd w within +-N T_max. A controller of "
                   "forces commands a position that moves along with the path, tick by tick; it "
                   "aims a few ticks ahead: a muscle_horizon of one alone overshoots",
                   WINCH_POSITION,
                   Command("rest_length", "m", 0.0, "longest_rest_length"), _DRUM_STATES, True),
        TensionLaw("heavy_cable", "an elastic cable that sags by its weight between two points",
                   "Irvine 1981, Cable Structures: the elastic catenary, in equilibrium at every "
                   "moment. f is the tension along the chord, H l / a, + d l'; both ends are "
                   "pulled down beside, together by the cable's weight", HEAVY_CABLE,
                   Command("rest_length", "m", 0.0, "longest_rest_length")),
    )
}  # fmt: skip
"""The laws that are simulated, by kind."""

WINCHES = ("winch", "winch_position")
"""The laws that have a drum."""

PRESETS: dict[str, CableModel] = {
    "roboy_myo_muscle": CableModel("series_elastic_motor", ROBOY_MYO_MUSCLE),
    "roboy_test_bench": CableModel("series_elastic_motor", ROBOY_TEST_BENCH),
}
"""Published sets of parameters, by name."""


def law_of(model: CableModel) -> TensionLaw:
    """The law that a muscle is simulated by: `ideal` for what is described only."""
    if model.own is not None:
        command = None if model.own.command is None else Command(*model.own.command)
        return TensionLaw("own", "a law of one's own", f"{model.own.file}:{model.own.name}",
                          command=command)  # fmt: skip
    return TENSION_LAWS.get(model.kind, TENSION_LAWS["ideal"])


def law_parameters(model: CableModel) -> dict[str, float]:
    """All parameters of a muscle's law, in the C core's order, defaults filled in.

    Args:
        model: A model without errors; see `check`.

    Raises:
        InputError: A parameter without a default is not given.
    """
    given = dict(model.parameters)
    values = {}
    for parameter in law_of(model).parameters:
        value = given.get(parameter.name, parameter.default)
        if value is None:
            raise InputError(f"{model.kind}: parameter {parameter.name!r} is missing")
        values[parameter.name] = value
    return values


def muscle_parameters(muscle: Muscle) -> dict[str, float]:
    """All parameters of a muscle's law, with what its pulley adds to its winch.

    A pulley of radius R turns by r / R as far as a drum of radius r: it adds J (r / R)^2 to the
    drum's inertia, and Tc r / R to its dry friction.

    Args:
        muscle: A muscle without errors; see `check`.
    """
    values = law_parameters(muscle.model)
    if muscle.pulley is not None and law_of(muscle.model).kind in WINCHES:
        ratio = values["drum_radius"] / muscle.pulley.radius[0]
        values["drum_inertia"] += muscle.pulley.number("inertia") * ratio**2
        values["dry_friction"] += muscle.pulley.number("bearing_friction") * ratio
    return values


def command_range(model: CableModel) -> tuple[float, float]:
    """Smallest and largest command of a muscle; (0, 0) for a passive one."""
    command = law_of(model).command
    if command is None:
        return 0.0, 0.0
    values = law_parameters(model)
    return _limit(command.low, values), _limit(command.high, values)


def states_of(model: CableModel) -> tuple[LawState, ...]:
    """The states that a muscle has with its parameters, in order."""
    law = law_of(model)
    if not law.states:
        return ()
    values = law_parameters(model)
    return tuple(state for state in law.states if not state.where or values[state.where] != 0.0)


def _limit(limit: float | str, values: Mapping[str, float]) -> float:
    if not isinstance(limit, str):
        return limit
    return -values[limit[1:]] if limit.startswith("-") else values[limit]
