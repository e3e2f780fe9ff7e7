"""Settings of a plant: its engine, integrator, step and substeps."""

from __future__ import annotations

from numbers import Real
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError

if TYPE_CHECKING:
    from addin_sdfusion.robot import Robot
    from sim_dart.scene import Scene

Engine = Literal["auto", "core", "dart"]
"""`core` for trees without contacts; `dart` for all; `auto` for the core if it can."""

ENGINES: tuple[Engine, ...] = get_args(Engine)

Rule = Literal["euler", "rk4"]

_USE_EULER = 'use integrator = "euler"'

MAX_SUBSTEPS = 1_000_000
"""The bound of native plants too."""


def check_step(step: float, integrator: str, substeps: int) -> None:
    """Reject settings out of range.

    Raises:
        InputError: One is wrong.
    """
    if not _is_number(step) or not (np.isfinite(step) and step > 0):
        raise InputError(f"the plant's step must be a positive time in s, not {step!r}")
    if integrator not in get_args(Rule):
        raise InputError(f"integrator {integrator!r} is not one of {', '.join(get_args(Rule))}")
    is_whole = _is_number(substeps) and 1 <= substeps <= MAX_SUBSTEPS
    if not is_whole or substeps != int(substeps):
        raise InputError(
            f"substeps must be a whole number from 1 to {MAX_SUBSTEPS}, not {substeps!r}"
        )


def _is_number(value: object) -> bool:
    """Return whether it is one that a float can be."""
    try:
        return isinstance(value, Real) and abs(float(value)) >= 0.0
    except OverflowError:
        return False


def chosen_engine(engine: str, scene: Scene | None, robot: Robot) -> Literal["core", "dart"]:
    """Return the engine that computes a plant.

    Args:
        engine: An engine, or `auto`.
        scene: The scene around the robot; None for none.
        robot: The robot.

    Raises:
        InputError: The engine is `core`, and the core lacks something that the plant needs.
        UnknownNameError: There is no such engine.
    """
    if engine not in ENGINES:
        raise UnknownNameError("engine", engine, ENGINES)
    lacking = core_lacks(scene, robot)
    if engine == "core" and lacking is not None:
        raise InputError(f'the engine "core" has no {lacking}; use engine = "dart"')
    return "dart" if engine == "dart" or lacking is not None else "core"


def refuse_loops_in_dart(robot: Robot, scene: Scene | None) -> None:
    """Reject a robot with loops where DART is to compute it.

    Args:
        robot: The robot.
        scene: The scene around it; None for none.

    Raises:
        InputError: It has loops.
    """
    if robot.loops:
        lacking = core_lacks(scene, robot)
        why = 'not the engine "dart"' if lacking is None else f"which has no {lacking}"
        problem = f'closes a loop, which the engine "core" alone computes, {why}'
        raise InputError(f"joint {robot.loops[0].name!r}: {problem}")


def refuse_rk4(engine: str, scene: Scene | None, robot: Robot) -> None:
    """Reject what the integrator `rk4` does not have.

    Args:
        engine: The engine.
        scene: The scene around the robot; None for none.
        robot: The robot.

    Raises:
        InputError: The C core, which alone has `rk4`, does not compute the plant; or it has
            friction that no explicit rule can hold at rest: Coulomb friction jumps with the sign of
            the velocity, friction of cables turns round within a fraction of a millimetre.
    """
    lacking = core_lacks(scene, robot) or ('the engine "dart"' if engine == "dart" else None)
    if lacking is not None:
        raise InputError(f"rk4 does not support {lacking}; {_USE_EULER}")
    cables = [muscle.name for muscle in robot.muscles if muscle.bend_friction]
    rough = [c.name for c in robot.coordinates if c.friction]
    for kind, names in (("friction of cables", cables), ("Coulomb friction", rough)):
        if names:
            raise InputError(
                f"rk4 does not support {kind}, and {', '.join(names)} has some; {_USE_EULER}"
            )


def core_lacks(scene: Scene | None, robot: Robot) -> str | None:
    """Return a feature of the plant that the C core does not have, in words; None if it has all.

    Args:
        scene: The scene around the robot; None for none.
        robot: The robot.
    """
    return python_laws(robot) if scene is None else "worlds with contacts"


def python_laws(robot: Robot) -> str | None:
    """Return the muscles whose laws are in Python, in words, or None."""
    own = {m.model.custom.name: m.name for m in robot.muscles if m.model.custom is not None}
    return next((f"muscle laws in Python ({law} of {name})" for law, name in own.items()), None)
