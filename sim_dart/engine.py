"""What computes a plant: the C core, or DART; and what the core lacks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

from addin_sdfusion.robot import InputError, Robot, UnknownNameError

if TYPE_CHECKING:
    from .scene import Scene

Engine = Literal["auto", "core", "dart"]
"""`core` for trees without contacts; `dart` for all; `auto` for the core where it can."""

ENGINES: tuple[Engine, ...] = get_args(Engine)


def chosen_engine(wanted: str, robot: Robot, scene: Scene | None) -> Literal["core", "dart"]:
    """The engine that computes a plant.

    Args:
        wanted: An engine, or `auto`.
        robot: The robot.
        scene: What stands around it; None for nothing.

    Raises:
        InputError: The core lacks something that is asked of it.
        UnknownNameError: There is no such engine.
    """
    if wanted not in ENGINES:
        raise UnknownNameError("engine", wanted, ENGINES)
    lacking = core_lacks(robot, scene)
    if wanted == "core" and lacking is not None:
        raise InputError(f'the engine "core" has no {lacking}; use engine = "dart"')
    return "dart" if wanted == "dart" or lacking is not None else "core"


def core_lacks(robot: Robot, scene: Scene | None) -> str | None:
    """What of this the C core does not have, in words; None if it has everything.

    Args:
        robot: The robot.
        scene: What stands around it; None for nothing.
    """
    if scene is not None:
        return "worlds with contacts"
    rough = [coordinate.name for coordinate in robot.coordinates if coordinate.friction]
    if rough:
        return f"Coulomb friction, and joints have some ({', '.join(rough)})"
    return None
