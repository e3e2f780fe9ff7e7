"""What computes a plant: the C core, or DART; and what the core lacks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

from addin_sdfusion.robot import InputError, UnknownNameError

if TYPE_CHECKING:
    from sim_dart.scene import Scene

Engine = Literal["auto", "core", "dart"]
"""`core` for trees without contacts; `dart` for all; `auto` for the core where it can."""

ENGINES: tuple[Engine, ...] = get_args(Engine)


def chosen_engine(wanted: str, scene: Scene | None) -> Literal["core", "dart"]:
    """The engine that computes a plant.

    Args:
        wanted: An engine, or `auto`.
        scene: What stands around the robot; None for nothing.

    Raises:
        InputError: The core lacks something that is asked of it.
        UnknownNameError: There is no such engine.
    """
    if wanted not in ENGINES:
        raise UnknownNameError("engine", wanted, ENGINES)
    lacking = core_lacks(scene)
    if wanted == "core" and lacking is not None:
        raise InputError(f'the engine "core" has no {lacking}; use engine = "dart"')
    return "dart" if wanted == "dart" or lacking is not None else "core"


def core_lacks(scene: Scene | None) -> str | None:
    """What of this the C core does not have, in words; None if it has everything.

    Args:
        scene: What stands around the robot; None for nothing.
    """
    return None if scene is None else "worlds with contacts"
