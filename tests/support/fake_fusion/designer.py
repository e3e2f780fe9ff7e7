"""User who edits a design: renames, moves, copies, suppresses and updates its parts.

Each action is one undo step. Occurrences are named by their path in the root component.
"""

from __future__ import annotations

import re
from copy import copy
from typing import Any

import numpy as np

from .maths import inverse
from .model.component import rename_occurrences
from .model.data import (
    ComponentData,
    DesignData,
    GroupData,
    OccurrenceData,
    Path,
    paths_below,
    transform,
)
from .model.entity import unique
from .state import world

_SUFFIX = re.compile(r" v\d+$")


class Designer:
    """Actions of a user in one design."""

    def __init__(self, design: DesignData) -> None:
        self._design = design

    def paths(self) -> dict[str, Path]:
        """Return all occurrences by path."""
        return {"+".join(o.name for o in p): p for p in paths_below(self._design.root)}

    def rename(self, path: str, name: str) -> None:
        """Rename the component of an occurrence; the names of its occurrences follow."""
        self._rename(self.paths()[path][-1].component, name)

    def get_latest(self, path: str, version: int | None) -> None:
        """Update an external reference; its name gets the suffix of the version, or none."""
        component = self.paths()[path][-1].component
        plain = _SUFFIX.sub("", component.name)
        self._rename(component, plain if version is None else f"{plain} v{version}")

    def move(self, path: str, to: str) -> None:
        """Drag an occurrence into the component of another occurrence; it keeps its pose."""
        paths = self.paths()
        held, goal = paths[path], paths[to] if to else ()
        parent = goal[-1].component if goal else self._design.root
        T = inverse(transform(goal)) @ transform(held)
        with world().transaction():
            world().remove(held[-1].parent.occurrences, held[-1], "move")
            world().append(parent.occurrences, held[-1], "move")
            world().set(held[-1], "parent", parent, "move")
            world().set(held[-1], "T", T, "move")

    def turn(self, path: str, T: Any) -> None:
        """Move an occurrence to another pose in its parent and capture the position."""
        with world().transaction():
            world().set(self.paths()[path][-1], "T", np.array(T, dtype=float), "turn")

    def paste(self, path: str, T: Any) -> str:
        """Paste another occurrence of a component next to an occurrence."""
        held = self.paths()[path]
        made = self._occurrence(held[-1].component, held[-1].parent, T)
        return "+".join([*(o.name for o in held[:-1]), made.name])

    def paste_new(self, path: str, T: Any) -> str:
        """Paste a new component: its points, attributes and bodies are copied [inferred]."""
        held = self.paths()[path]
        old = held[-1].component
        new = self._component_like(old, unique(old.name, self._design.components))
        with world().transaction():
            world().append(self._design.components, new, "paste new")
        made = self._occurrence(new, held[-1].parent, T)
        return "+".join([*(o.name for o in held[:-1]), made.name])

    def suppress(self, path: str, suppressed: bool = True) -> None:
        """Suppress an occurrence."""
        held = self.all_paths()[path][-1]
        with world().transaction():
            world().set(held, "suppressed", suppressed, "suppress")

    def configure(self, *suppressed: str) -> None:
        """Activate a configuration of the design, which suppresses exactly these occurrences."""
        with world().transaction():
            for path, held in self.all_paths().items():
                world().set(held[-1], "suppressed", path in suppressed, "configure")

    def switch_configuration(self, path: str, row: str) -> str:
        """Use another configuration of an external reference, and return the new path.

        Each configuration is a component with its own id [inferred].
        """
        above, held = self.paths()[path][:-1], self.paths()[path][-1]
        name = f"{held.component.name.partition(' (')[0]} ({row})"
        known = [c for c in self._design.components if c.name == name]
        variant = known[0] if known else self._component_like(held.component, name)
        number = self._free_number(variant)
        with world().transaction():
            if not known:
                world().append(self._design.components, variant, "switch")
            world().set(held, "component", variant, "switch")
            world().set(held, "name", f"{name}:{number}", "switch")
        return "+".join(o.name for o in (*above, held))

    def all_paths(self) -> dict[str, Path]:
        """Return all occurrences by path, including suppressed ones."""
        found: dict[str, Path] = {}

        def walk(component: ComponentData, above: Path) -> None:
            for o in component.occurrences:
                found["+".join(p.name for p in (*above, o))] = (*above, o)
                walk(o.component, (*above, o))

        walk(self._design.root, ())
        return found

    def resolve(self, path: str, resolved: bool = True) -> None:
        """Find or lose the document of an external reference."""
        with world().transaction():
            world().set(self.paths()[path][-1], "unresolved", not resolved, "resolve")

    def delete(self, path: str) -> None:
        """Delete an occurrence, and its component if it was the last one."""
        held = self.paths()[path][-1]
        with world().transaction():
            world().set(held, "gone", True, "delete")
            world().remove(held.parent.occurrences, held, "delete")
            component = held.component
            used = [o.component for c in self._design.components for o in c.occurrences]
            if component not in used and component in self._design.components:
                world().remove(self._design.components, component, "delete")

    def group(self, name: str, *paths: str) -> None:
        """Create a rigid group in the root component."""
        members = [self.paths()[path] for path in paths]
        made = GroupData(name, component=self._design.root, members=members)
        with world().transaction():
            world().append(self._design.root.groups, made, "group")

    def _rename(self, component: ComponentData, name: str) -> None:
        others = [c for c in self._design.components if c is not component]
        with world().transaction():
            world().set(component, "name", unique(name, others), "rename")
            rename_occurrences(component)

    def _occurrence(self, component: ComponentData, parent: Any, T: Any) -> OccurrenceData:
        name = f"{component.name}:{self._free_number(component)}"
        made = OccurrenceData(name, component=component, parent=parent, T=np.array(T, dtype=float))
        with world().transaction():
            world().append(parent.occurrences, made, "paste")
        return made

    def _free_number(self, component: ComponentData) -> int:
        held = [o for c in self._design.components for o in c.occurrences]
        numbers = [int(o.name.rpartition(":")[2]) for o in held if o.component is component]
        return max(numbers, default=0) + 1

    def _component_like(self, old: ComponentData, name: str) -> ComponentData:
        new = ComponentData(
            name, design=self._design, opacity=old.opacity, referenced=old.referenced
        )
        new.source = old.source
        new.points = [_copied(point, new) for point in old.points]
        new.bodies = [_copied(body, new) for body in old.bodies]
        for body, before in zip(new.bodies, old.bodies, strict=True):
            if before.parts is not None:
                body.parts = tuple([_part(p, body) for p in parts] for parts in before.parts)
        return new


def _copied(item: Any, component: ComponentData) -> Any:
    """Return a copy of a point or body with its attributes in another component."""
    made = copy(item)
    made.attributes = dict(item.attributes)
    made.component = component
    if hasattr(made, "parts"):
        made.parts = None
    made.__dict__.pop("base_feature", None)
    return made


def _part(part: Any, body: Any) -> Any:
    made = copy(part)
    made.attributes, made.body = dict(part.attributes), body
    return made
