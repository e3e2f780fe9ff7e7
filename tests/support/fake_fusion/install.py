"""Installation of the fake as modules `adsk.core` and `adsk.fusion`."""

from __future__ import annotations

import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from . import app, curves, enums, maths
from .base import CLASSES, Base, api, check_thread
from .model import (
    base_features,
    bodies,
    captures,
    component,
    entity,
    joints,
    motion_links,
    points,
    rigid_groups,
)
from .state import replace_world, world
from .ui import graphics

__all__ = [
    "app",
    "base_features",
    "bodies",
    "captures",
    "component",
    "curves",
    "entity",
    "enums",
    "graphics",
    "install",
    "joints",
    "maths",
    "modules",
    "motion_links",
    "points",
    "rigid_groups",
]

_MODULES: dict[str, types.ModuleType] = {}


def do_events() -> None:
    """Count a call of `adsk.doEvents`, and process one waiting event of the user interface."""
    check_thread("adsk.doEvents")
    world().do_events += 1
    if world().waiting:
        world().waiting.popleft()()


def adsk_modules() -> dict[str, types.ModuleType]:
    """Return the modules `adsk`, `adsk.core`, `adsk.fusion`, by name; always the same ones."""
    if not _MODULES:
        api("adsk.core")(Base)
        adsk = types.ModuleType("adsk", "Fake of Fusion's API.")
        adsk.__path__ = []  # type: ignore[attr-defined]
        adsk.doEvents = do_events  # type: ignore[attr-defined]
        _MODULES["adsk"] = adsk
        for name in ("adsk.core", "adsk.fusion"):
            module = types.ModuleType(name)
            module.__dict__.update(CLASSES[name])
            setattr(adsk, name.partition(".")[2], module)
            _MODULES[name] = module
    return _MODULES


@contextmanager
def modules() -> Iterator[None]:
    """Make `import adsk.core, adsk.fusion` import the fake within the context."""
    made = adsk_modules()
    before = {name: sys.modules.get(name) for name in made}
    sys.modules.update(made)
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                sys.modules.pop(name, None)
            else:
                sys.modules[name] = module


@contextmanager
def install() -> Iterator[Any]:
    """Start a new Fusion without documents, install the modules, and yield the Fake."""
    from .control import Fake

    before = replace_world()
    try:
        with modules():
            yield Fake()
    finally:
        replace_world(before)
