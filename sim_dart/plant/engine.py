"""Choice of the engine of a plant: the C core, or DART."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

from addin_sdfusion.robot import InputError, UnknownNameError

if TYPE_CHECKING:
    from sim_dart.scene import Scene

Engine = Literal["auto", "core", "dart"]
"""`core` for trees without contacts; `dart` for all; `auto` for the core where it can."""

ENGINES: tuple[Engine, ...] = get_args(Engine)


def chosen_engine(engine: str, scene: Scene | None) -> Literal["core", "dart"]:
    """The engine that computes a plant.

    Args:
        engine: An engine, or `auto`.
        scene: The scene around the robot; None for none.

    Raises:
        InputError: The engine is `core`, and the core lacks something that the plant needs.
        UnknownNameError: There is no such engine.
    """
    if engine not in ENGINES:
        raise UnknownNameError("engine", engine, ENGINES)
    lacking = core_lacks(scene)
    if engine == "core" and lacking is not None:
        raise InputError(f'the engine "core" has no {lacking}; use engine = "dart"')
    return "dart" if engine == "dart" or lacking is not None else "core"


def core_lacks(scene: Scene | None) -> str | None:
    """A feature of the plant that the C core does not have, in words; None if it has all.

    Args:
        scene: The scene around the robot; None for none.
    """
    return None if scene is None else "worlds with contacts"
