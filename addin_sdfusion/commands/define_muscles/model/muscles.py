"""Edits of muscles: choice, name, properties, mirrored and imported muscles."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ....muscles.merge import merge
from ....muscles.mirror import FindFace, Plane, mirror_muscle, other_side
from ....muscles.table import MuscleTable
from ....robot.errors import InputError
from ....robot.model.muscle import CableKind
from ....robot.model.muscle_laws import law_of
from ....snapshot import MuscleSnapshot
from .model import MuscleModel


def choose(model: MuscleModel, muscle: str) -> None:
    """Choose the muscle to which picked points are added; a new muscle if empty."""
    if not muscle:
        muscle = model.table.new_muscle_name()
        model.table = model.table.with_muscle(MuscleSnapshot(muscle, model.table.next_color()))
        model.message = f"{muscle} is new: pick its points, in order."
    model.muscle = muscle
    model.insert_at = None


def rename(model: MuscleModel, name: str, muscle: str | None = None) -> None:
    """Rename a muscle (default: the chosen one); reject an empty or existing name.

    If no muscle exists, a new muscle gets the name.
    """
    name, old = name.strip(), model.muscle if muscle is None else muscle
    if name == old:
        return
    if not name or not name.isprintable():
        raise InputError("The name of a muscle must contain visible characters.")
    if model.table.row(name) is not None:
        raise InputError(f"Muscle {name} exists already; choose another name.")
    if not old:
        choose(model, "")
        old = model.muscle
    model.table = model.table.rename_muscle(old, name)
    model.muscle = name if old == model.muscle else model.muscle


def delete(model: MuscleModel) -> None:
    """Delete the chosen muscle with its points."""
    if model.muscle:
        model.table = model.table.delete_muscle(model.muscle)
        model.message = f"{model.muscle} is deleted."
        model.muscle = model.table.rows[0].name if model.table.rows else ""
        model.insert_at = None


def change(model: MuscleModel, /, muscle: str | None = None, **changes: Any) -> None:
    """Change properties of a muscle (default: the chosen one)."""
    row = model.table.row(model.muscle if muscle is None else muscle)
    if row is not None:
        model.table = model.table.with_muscle(replace(row, **changes))


def change_law(model: MuscleModel, muscle: str, law: CableKind) -> None:
    """Change the muscle law of a muscle and keep the parameters that both laws have."""
    row = model.table.row(muscle)
    if row is not None:
        names = parameter_names(replace(row, model=law, parameters={}))
        parameters = {name: number for name, number in row.parameters.items() if name in names}
        change(model, muscle, model=law, parameters=parameters)


def parameter_names(row: MuscleSnapshot) -> list[str]:
    """Return the parameters of the muscle law, then the stored parameters unknown to it."""
    names = [p.name for p in law_of(row.cable_model).parameters]
    return list(dict.fromkeys([*names, *row.parameters]))


def mirror(
    model: MuscleModel, plane: Plane, every: bool, replace_existing: bool, find_face: FindFace
) -> None:
    """Mirror the chosen muscle, or all muscles of its side, to the other side."""
    muscles = [model.muscle] if model.muscle else []
    if every:
        side = _side(model.muscle)
        muscles = [row.name for row in model.table.rows if _side(row.name) == side]
    texts: list[str] = []
    mirrored: list[str] = []
    for muscle in muscles:
        table, findings = mirror_muscle(
            model.table, muscle, plane, model.links, replace_existing, find_face
        )
        texts += [finding.message for finding in findings]
        before = model.table.points_of
        mirrored += [r.name for r in table.rows if table.points_of(r.name) != before(r.name)]
        model.table = table
    texts.append(f"Mirrored: {', '.join(mirrored)}." if mirrored else "Nothing was mirrored.")
    model.message = "\n".join(texts)


def _side(name: str) -> str:
    """Return `left` or `right`, depending on the side in a name, or an empty string."""
    other = other_side(name)
    if other is None:
        return ""
    changed = next(a for a, b in zip(name.lower(), other.lower(), strict=False) if a != b)
    return "left" if changed == "l" else "right"


def take(model: MuscleModel, table: MuscleTable) -> None:
    """Merge a table read from a file, which replaces equal names."""
    model.table = merge(model.table, table).renumber()
    if table.rows:
        choose(model, table.rows[0].name)
