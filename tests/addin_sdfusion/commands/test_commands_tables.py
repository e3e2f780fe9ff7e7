"""Tests of the tables of Define muscles and of the clipboard."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from support.designs.user import User


def test_all_muscles_are_in_one_table(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle())
    command.set("muscle", "+ New muscle")
    command.pick("pick", user.own_point())
    command.set(command.cell("all", 1, 0).id, "biceps")
    for text in ("7", "7.", "7.5"):
        command.set(command.cell("all", 1, 1).id, text)
        assert command.cell("all", 1, 1).value == text
    command.set(command.cell("all", 2, 2).id, "many")
    assert "'many' is not a number" in command["status"].text
    command.set(command.cell("all", 2, 3).id, "elastic_cable")
    rows = command.table("all")[1:]
    assert [row[:4] for row in rows] == [
        ["biceps", "7.5", "80", "ideal"],
        ["motor1", "10", "80", "elastic_cable"],
    ]
    command.ok()
    stored = json.loads(fusion.design.attributes.itemByName("CARDSFlow", "muscles").value)
    assert [(m["name"], m["f_min"], m["model"]) for m in stored] == [
        ("biceps", 7.5, "ideal"),
        ("motor1", 10.0, "elastic_cable"),
    ]


def test_typed_coordinates_move_a_point(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3), user.circle())
    x, y, _ = command.table("points")[1][2].split(", ")
    command.set(command.cell("points", 1, 2).id, f"{x}, {y}")
    assert "must be x, y, z in mm" in command["status"].text
    command.set(command.cell("points", 1, 2).id, f"{x}; {y}; 123,5")
    command.ok()
    (name,) = [n for n in user.points() if n.endswith("_0")]
    place = user.points()[name]
    assert place[2] == pytest.approx(12.35, abs=1e-9)  # in cm
    assert len(fusion.world.undo_steps) == 1


PROGRAM = "import pathlib, sys; f = pathlib.Path({!r}); {}"
TAKE, GIVE = "f.write_bytes(sys.stdin.buffer.read())", "sys.stdout.buffer.write(f.read_bytes())"


def test_points_are_copied_to_and_pasted_from_a_spreadsheet(
    fusion: Any, user: User, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from addin_sdfusion.commands import clipboard

    command = user.define(user.vertex(3), user.circle())
    command.press("copy")
    assert "clipboard is not available" in command["status"].text
    file = tmp_path / "clipboard"
    programs = [(sys.executable, "-c", PROGRAM.format(str(file), w)) for w in (TAKE, GIVE)]
    monkeypatch.setitem(clipboard.PROGRAMS, sys.platform, tuple(programs))
    command.set("muscle_name", "bizeps_rückwärts")
    command.press("copy")
    text = file.read_text(encoding="utf-8")
    assert text.splitlines()[1].split("\t")[1] == "bizeps_rückwärts"
    file.write_text(text.replace("bizeps_rückwärts", "trizeps"), encoding="utf-8")
    command.press("paste")
    assert "1 muscles with 2 points" in command["status"].text
    assert [row[0] for row in command.table("all")[1:]] == ["bizeps_rückwärts", "trizeps"]
    file.write_text("nonsense", encoding="utf-8")
    command.press("paste")
    assert "was not imported" in command["status"].text
    command.cancel()


def test_a_colour_is_chosen_by_name(fusion: Any, user: User) -> None:
    command = user.define(user.vertex(3))
    command.set("palette", "Green")
    assert command["color"].value == "#2ca02c"
    command.set("color", "#123456")
    assert command.chosen("palette") == ["Custom"]
    command.set("palette", "Custom")
    assert command["color"].value == "#123456"
    command.cancel()
