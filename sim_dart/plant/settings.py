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
"""`core` for the C core, without contacts; `dart`; `auto` for the core if possible."""

ENGINES: tuple[Engine, ...] = get_args(Engine)

Rule = Literal["euler", "rk4"]

_USE_EULER = 'use integrator = "euler"'

MAX_SUBSTEPS = 1_000_000
"""Largest number of substeps, also in native plants."""


def check_step(step: float, integrator: str, substeps: int) -> None:
    """Check the settings of a plant.

    Raises:
        InputError: A setting is out of range.
    """
    if not _is_number(step) or not (np.isfinite(step) and step > 0):
        raise InputError(f"the step of the plant must be a positive time in s, not {step!r}")
    if integrator not in get_args(Rule):
        raise InputError(f"unknown integrator {integrator!r}; known: {', '.join(get_args(Rule))}")
    is_whole = _is_number(substeps) and 1 <= substeps <= MAX_SUBSTEPS
    if not is_whole or substeps != int(substeps):
        raise InputError(
            f"substeps must be a whole number from 1 to {MAX_SUBSTEPS}, not {substeps!r}"
        )


def _is_number(value: object) -> bool:
    """Return whether a value is a number that can be converted to float."""
    try:
        return isinstance(value, Real) and abs(float(value)) >= 0.0
    except OverflowError:
        return False


def select_engine(engine: str, scene: Scene | None, robot: Robot) -> Literal["core", "dart"]:
    """Return the engine that computes a plant.

    Args:
        engine: An engine, or `auto`.
        scene: The scene around the robot, or None.

    Raises:
        InputError: The engine is `core`, which does not support a feature of the plant.
        UnknownNameError: The engine does not exist.
    """
    if engine not in ENGINES:
        raise UnknownNameError("engine", engine, ENGINES)
    unsupported = unsupported_by_core(scene, robot)
    if engine == "core" and unsupported is not None:
        raise InputError(f'the engine "core" does not support {unsupported}; use engine = "dart"')
    return "dart" if engine == "dart" or unsupported is not None else "core"


def reject_loops_in_dart(robot: Robot, scene: Scene | None) -> None:
    """Reject a robot with loops, which DART does not support.

    Args:
        scene: The scene around the robot, or None.

    Raises:
        InputError: The robot has loops.
    """
    if robot.loops:
        unsupported = unsupported_by_core(scene, robot)
        why = 'not the engine "dart"' if unsupported is None else f"but not with {unsupported}"
        problem = f'closes a loop, which only the engine "core" supports, {why}'
        raise InputError(f"joint {robot.loops[0].name!r}: {problem}")


def require_rk4_support(engine: str, scene: Scene | None, robot: Robot) -> None:
    """Check that the integrator `rk4` supports a plant.

    Args:
        scene: The scene around the robot, or None.

    Raises:
        InputError: The C core, which `rk4` requires, does not support the plant, or the plant has
            friction. Explicit rules cannot integrate friction: Coulomb friction is discontinuous,
            and cable friction changes its direction within a fraction of a millimetre.
    """
    unsupported = unsupported_by_rk4(engine, scene, robot)
    if unsupported is not None:
        raise InputError(f"rk4 does not support {unsupported}; {_USE_EULER}")


def unsupported_by_rk4(engine: str, scene: Scene | None, robot: Robot) -> str | None:
    """Return the description of a feature without time derivatives, or None.

    Args:
        scene: The scene around the robot, or None.
    """
    unsupported = unsupported_by_core(scene, robot)
    if unsupported is not None or engine == "dart":
        return unsupported or 'the engine "dart"'
    cables = [muscle.name for muscle in robot.muscles if muscle.bend_friction]
    rough = [c.name for c in robot.coordinates if c.friction]
    for kind, names in (("cable friction", cables), ("Coulomb friction", rough)):
        if names:
            return f"{kind} (of {', '.join(names)})"
    return None


def unsupported_by_core(scene: Scene | None, robot: Robot) -> str | None:
    """Return the description of a feature that the C core does not support, or None.

    Args:
        scene: The scene around the robot, or None.
    """
    return custom_law_feature(robot) if scene is None else "worlds with contacts"


def custom_law_feature(robot: Robot) -> str | None:
    """Return the description of a muscle with a custom law in Python, or None."""
    laws = {m.model.custom.name: m.name for m in robot.muscles if m.model.custom is not None}
    return next((f"muscle laws in Python ({law} of {name})" for law, name in laws.items()), None)
