"""Tests that all names of Fusion's API in the fake and the add-in exist in the reference.

The reference is a list of the members of all classes of the fake in the repository, and the list of
all members of the API next to the repository, if it exists.
"""

from __future__ import annotations

import ast
import json
import re
import types
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from fake_fusion.base import CLASSES, Base
from fake_fusion.install import adsk_modules

ROOT = Path(__file__).parents[3]
LIST = ROOT / "../shared/adsk/members_2026-01.json"
OWN = ROOT / "tests/support/fake_fusion/members.json"
ADDIN = ROOT / "addin_sdfusion"
EVERYWHERE = {"isValid", "objectType", "classType", "cast"}
PYTHON = {"add", "remove", "item", "count"}


class Reference:
    """Reference of the API: classes, members, writable members, and values of enumerations."""

    def __init__(self, classes: dict[str, Any]) -> None:
        self._classes = classes

    def __contains__(self, name: str) -> bool:
        return name in self._classes

    def values(self, name: str) -> dict[str, int]:
        """Return the values of an enumeration; empty for a class."""
        return self._classes[name]["values"]

    def members(self, name: str) -> dict[str, dict[str, Any]]:
        """Return the members of a class and its bases, without retired ones."""
        if name not in self._classes:
            return {}
        entry = self._classes[name]
        base = entry.get("base")
        found = self.members(base) if base and base != name else {}
        return {**found, **entry["members"]}

    def every_member(self) -> set[str]:
        """Return the names of all members of all classes."""
        return {
            m for entry in self._classes.values() for m in (*entry["members"], *entry["values"])
        }


@cache
def from_list(file: Path) -> Reference:
    classes = {}
    for name, entry in json.loads(file.read_text(encoding="utf-8")).items():
        members = {
            member: {"kind": detail["k"], "writable": _is_writable(detail)}
            for member, detail in entry.get("detail", {}).items()
            if not detail.get("retired")
        }
        values = entry.get("values") or {}
        classes[name] = {"base": entry.get("base"), "members": members, "values": values}
    return Reference(classes)


def _is_writable(detail: dict[str, Any]) -> bool:
    syntax = detail.get("syn") or ""
    return detail["k"] == "P" and not syntax.startswith("propertyValue")


@cache
def from_own_list() -> Reference:
    """Read the members of the classes of the fake, which are listed in the repository."""
    classes = {}
    for name, (base, kinds, values) in json.loads(OWN.read_text(encoding="utf-8")).items():
        members = {
            member: {"kind": "P" if kind == "W" else kind, "writable": kind == "W"}
            for member, kind in kinds.items()
        }
        classes[name] = {"base": base or None, "members": members, "values": values}
    return Reference(classes)


@pytest.fixture(params=["repository", "complete"])
def reference(request: pytest.FixtureRequest) -> Reference:
    if request.param == "repository":
        return from_own_list()
    if not LIST.is_file():
        pytest.skip("the complete list of members is not next to the repository")
    return from_list(LIST)


# The fake ----------------------------------------------------------------------------------------


def public(cls: type) -> dict[str, Any]:
    """Return the public members of a class of the fake and its bases."""
    found: dict[str, Any] = {}
    for base in reversed(cls.__mro__[:-1]):
        found.update({n: m for n, m in vars(base).items() if not n.startswith("_")})
    return {n: m for n, m in found.items() if n not in EVERYWHERE}


def fake_classes() -> list[Any]:
    adsk_modules()
    return [
        pytest.param(namespace, name, id=f"{namespace}.{name}")
        for namespace, classes in CLASSES.items()
        for name in classes
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("namespace", "name"), fake_classes())
def test_fake_has_only_existing_names(namespace: str, name: str, reference: Reference) -> None:
    cls = CLASSES[namespace][name]
    if name not in reference:
        assert name == "Base", f"there is no {namespace}.{name}"
        return
    if not issubclass(cls, Base):
        known_values = reference.values(name)
        assert known_values.keys() & cls._values.keys()
        assert cls._values.keys() <= known_values.keys()
        for value in known_values.keys() & cls._values.keys():
            assert cls._values[value] == known_values[value], f"{name}.{value}"
        return
    known = reference.members(name)
    unknown = public(cls).keys() - known.keys()
    assert not unknown, f"{name} has no {', '.join(sorted(unknown))}"
    for member, found in public(cls).items():
        if member in known:
            is_property = isinstance(found, property)
            assert is_property == (known[member]["kind"] != "M"), f"{name}.{member}"
            if is_property and found.fset is not None:
                assert known[member]["writable"], f"{name}.{member} is read-only"


def test_fake_modules_contain_only_classes() -> None:
    modules = adsk_modules()
    assert set(modules) == {"adsk", "adsk.core", "adsk.fusion"}
    for name in ("adsk.core", "adsk.fusion"):
        names = {n for n in vars(modules[name]) if not n.startswith("__")}
        assert names == set(CLASSES[name])


@pytest.mark.parametrize(("cls", "member"), [("Occurrence", "transform"), ("Sketch", "project")])
def test_retired_members_are_absent(cls: str, member: str) -> None:
    adsk_modules()
    found = {**CLASSES["adsk.core"], **CLASSES["adsk.fusion"]}[cls]
    assert member not in public(found)


# The add-in --------------------------------------------------------------------------------------


def sources() -> list[Path]:
    """Return the source files of the add-in that use the API."""
    folders = (ADDIN / "fusion", ADDIN / "commands")
    return [ADDIN / "addin_sdfusion.py", *sorted(f for d in folders for f in d.rglob("*.py"))]


def problems(tree: ast.AST, reference: Reference, own: set[str]) -> Iterator[str]:
    """Yield the names in a source that do not exist.

    Args:
        tree: The source.
        reference: What exists.
        own: Names that the add-in itself defines, and members of Python's types and modules.
    """
    every = reference.every_member() | EVERYWHERE | PYTHON
    modules = imported(tree)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Attribute):
            continue
        words = chain(node)
        if words and words[0] == "adsk":
            yield from _wrong_chain(words, node.lineno, reference)
        elif not (words and words[0] in modules) and node.attr not in every | own:
            yield f"{node.lineno}: no class of the API has a member {node.attr!r}"


def _wrong_chain(words: list[str], line: int, reference: Reference) -> Iterator[str]:
    """Yield the problem of adsk.<module>.<class>.<member>."""
    if len(words) == 2 and words[1] not in ("core", "fusion", "doEvents", "autoTerminate"):
        yield f"{line}: no {'.'.join(words)}"
    if len(words) == 3 and words[2] not in reference:
        yield f"{line}: no class {'.'.join(words)}"
    if len(words) == 4 and words[2] in reference:
        known = reference.members(words[2]).keys() | reference.values(words[2]).keys()
        if words[3] not in known | EVERYWHERE:
            yield f"{line}: {words[2]} has no member {words[3]!r}"


def chain(node: ast.expr) -> list[str] | None:
    """Return the parts of `a.b.c`; None for an expression that does not begin with a name."""
    words: list[str] = []
    while isinstance(node, ast.Attribute):
        words.insert(0, node.attr)
        node = node.value
    return [node.id, *words] if isinstance(node, ast.Name) else None


def imported(tree: ast.AST) -> set[str]:
    """Return the names of imported modules and objects."""
    names = [n for n in ast.walk(tree) if isinstance(n, (ast.Import, ast.ImportFrom))]
    found = {(a.asname or a.name.partition(".")[0]) for n in names for a in n.names}
    return found - {"adsk"}


def defined(tree: ast.AST) -> set[str]:
    """Return the names that a source defines: functions, classes, variables, fields."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            if isinstance(node.value, ast.Name) and node.value.id == "self":
                found.add(node.attr)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
    return found


@cache
def own_names() -> set[str]:
    """Return all names that the add-in defines, and members of built-in types."""
    found: set[str] = set()
    for file in ADDIN.rglob("*.py"):
        found |= defined(ast.parse(file.read_text(encoding="utf-8")))
    plain = (str, bytes, list, dict, set, tuple, int, float, object, Exception, Path, type)
    for cls in (*plain, types.FunctionType, types.ModuleType, OSError, re.Pattern):
        found |= set(dir(cls))
    return found | {"tobytes", "frombytes"}


@pytest.mark.parametrize("file", sources(), ids=lambda file: str(file.relative_to(ADDIN)))
def test_addin_uses_only_existing_names(file: Path, reference: Reference) -> None:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    found = list(problems(tree, reference, own_names()))
    assert not found, "\n".join(found)


@pytest.mark.parametrize("file", sources(), ids=lambda file: str(file.relative_to(ADDIN)))
def test_addin_uses_only_names_of_the_fake(file: Path) -> None:
    """Otherwise a test could pass because the fake lacks a class."""
    modules = adsk_modules()
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        words = chain(node) if isinstance(node, ast.Attribute) else None
        if words and words[0] == "adsk" and len(words) in (3, 4) and words[1] in ("core", "fusion"):
            cls = getattr(modules[f"adsk.{words[1]}"], words[2])
            assert len(words) == 3 or hasattr(cls, words[3])


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("body.isVisble", "1: no class of the API has a member 'isVisble'"),
        ("adsk.fusion.JointTypes.WeldJointType", "1: JointTypes has no member 'WeldJointType'"),
        ("adsk.core.Matrix4D.create()", "1: no class adsk.core.Matrix4D"),
        ("adsk.forever()", "1: no adsk.forever"),
    ],
)
def test_checker_finds_wrong_names(source: str, problem: str, reference: Reference) -> None:
    assert problem in list(problems(ast.parse(source), reference, set()))


@pytest.mark.parametrize(
    "source",
    [
        "occurrence.transform2.invert()",
        "adsk.fusion.JointTypes.BallJointType",
        "adsk.fusion.Design.cast(app.activeProduct).rootComponent",
        "import math\nmath.tau",
    ],
)
def test_checker_accepts_correct_calls(source: str, reference: Reference) -> None:
    assert not list(problems(ast.parse(source), reference, set()))
