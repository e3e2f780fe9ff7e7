"""Random defects of files: in bytes, words, XML elements or archive members."""

from __future__ import annotations

import contextlib
import copy
import io
import random
import re
import warnings
import zipfile
import zlib
from pathlib import Path, PurePath
from xml.etree import ElementTree

NASTY = ["", " ", "nan", "inf", "-1e308 1e308 1", "1e-320", "1e999", "-1", "0", "9" * 400]
NASTY += ["world", "link_1", "link_2", "joint_1", "tip", "basic", "a\nb\tc", "é", "1 2 3", "true"]
NASTY += ["x y z", "xyzabg", "S_EULER_XYZ", "P_AXIS", "../x.traj", "1e308 -1e308 1e308", "relative"]
TAGS = ["cable_ideal", "cable_passive_linear_spring", "cable_vsd_polynomial", "attachment"]
TAGS += ["base_rotating_pulley", "screw_base_rotating_pulley", "position", "pose_euler_xyz"]
TAGS += ["orientation_euler_xyz", "operational_spaces", "parabolic_blend_trajectory"]
TAGS += ["cubic_spline_average_velocity_trajectory", "file_trajectory", "muscle_hill_type"]
WORDS = ["", "nan", "inf", "-inf", "1e-320", "1e308", "-1e308", "1e999", "-1", "0", "1", "2", "0.5"]
WORDS += [
    "2147483648",
    "1000000000",
    "-1000000",
    "18446744073709551616",
    "9" * 400,
    "9" * 5000,
    "null",
]
WORDS += [
    "true",
    "false",
    "[]",
    "{}",
    '""',
    '"a"',
    '"auto"',
    "[1, 2]",
    "[[",
    "{a = 1}",
    '"\\u0000"',
]
WORDS += ['"../../x"', '"/dev/zero"', '"é\\n"', "1979-05-27", "[" * 3000, '{"a":' * 3000, "time"]
INTEGERS = [b"\0", b"\xff", b"\x7f", b"\x80", b"\0" * 4, b"\xff" * 4, b"\xff\xff\xff\x7f"]
INTEGERS += [b"\0\0\0\x80", b"\0" * 8, b"\xff" * 8, b"\xff" * 7 + b"\x7f", b"\0\0\0\0\0\0\xf0\x7f"]
XML = (".xml", ".sdf", ".urdf", ".osim", ".dae", ".ssd", ".ssv", ".ssm")
TEXT = (
    ".toml",
    ".json",
    ".csv",
    ".obj",
    ".off",
    ".gltf",
    ".traj",
    ".txt",
    ".config",
    ".step",
    ".yaml",
    ".sto",
)
ARCHIVES = (".fmu", ".ssp", ".npz", ".zip")
UNREADABLE = (zipfile.BadZipFile, zlib.error, ValueError, RuntimeError, OSError, EOFError)
"""Exceptions of zipfile for damaged archives."""
_WORD = re.compile(rb'"[^"\n]*"|[-+]?\d[\d.eE+-]*|[A-Za-z_][\w.]*|[^\s\w]')


def damage(rng: random.Random, root: ElementTree.Element) -> None:
    """Remove, duplicate, move or rename an element, or replace a value."""
    nodes = list(root.iter())
    parents = [node for node in nodes if len(node)]
    if not parents:
        return
    parent = rng.choice(parents)
    child = rng.choice(list(parent))
    action = rng.choice(["remove", "double", "move", "rename", "text", "attribute"])
    if action == "remove":
        parent.remove(child)
    elif action == "double":
        parent.append(copy.deepcopy(child))
    elif action == "move":
        parent.remove(child)
        rng.choice(parents).insert(0, child)
    elif action == "rename":
        child.tag = rng.choice([*TAGS, *(node.tag for node in nodes)])
    elif action == "text":
        child.text = rng.choice(NASTY)
    elif child.attrib:
        name = rng.choice(sorted(child.attrib))
        value = rng.choice([None, *NASTY])
        child.attrib.pop(name)
        if value is not None:
            child.set(name, value)


def damaged_xml(rng: random.Random, data: bytes) -> bytes:
    """Return XML with one to four defects."""
    root = ElementTree.fromstring(data)
    for _ in range(rng.randint(1, 4)):
        damage(rng, root)
    return ElementTree.tostring(root, encoding="utf-8")


def damaged_words(rng: random.Random, data: bytes) -> bytes:
    """Return text with one to three words or lines replaced, duplicated, swapped or removed."""
    for _ in range(rng.randint(1, 3)):
        words = list(_WORD.finditer(data))
        lines = data.splitlines(keepends=True)
        if not words:
            return data
        one, other = rng.choice(words), rng.choice(words)
        action = rng.choice(["replace", "replace", "replace", "exchange", "double", "remove"])
        if action == "replace":
            data = data[: one.start()] + rng.choice(WORDS).encode() + data[one.end() :]
        elif action == "exchange":
            data = data[: one.start()] + other.group() + data[one.end() :]
        elif action == "double":
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
            data = b"".join(lines)
        else:
            lines.pop(rng.randrange(len(lines)))
            data = b"".join(lines)
    return data


def damaged_bytes(rng: random.Random, data: bytes) -> bytes:
    """Return bytes with one to four changes: overwritten, removed, inserted or truncated."""
    for _ in range(rng.randint(1, 4)):
        at = rng.randint(0, len(data))
        piece = rng.choice([rng.choice(INTEGERS), rng.randbytes(rng.randint(1, 4))])
        action = rng.random()
        if action < 0.6:
            data = data[:at] + piece + data[at + len(piece) :]
        elif action < 0.75:
            data = data[:at] + piece + data[at:]
        elif action < 0.9:
            data = data[:at] + data[at + rng.randint(1, 64) :]
        else:
            data = data[:at]
    return data


def damaged_archive(rng: random.Random, data: bytes) -> bytes:
    """Return an archive with one or two members damaged, renamed, removed or duplicated."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = [(entry.filename, archive.read(entry)) for entry in archive.infolist()]
    for _ in range(rng.randint(1, 2)):
        k = rng.randrange(len(members))
        name, content = members[k]
        action = rng.random()
        if action < 0.85:
            members[k] = name, damaged(rng, name, content)
        elif action < 0.9:
            members[k] = rng.choice(members)[0], content
        elif action < 0.95 or len(members) == 1:
            members[k] = rng.choice(["../x", "/x", "é", "a" * 300, name + "/b"]), content
        else:
            members.pop(k)
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # warns of two members with the same name
        for name, content in members:
            archive.writestr(zipfile.ZipInfo(name), content)
    return memory.getvalue()


def damaged(rng: random.Random, name: str, data: bytes) -> bytes:
    """Return the content of a file with defects of its type, or with changed bytes."""
    suffix, chance = PurePath(name).suffix.lower(), rng.random()
    if suffix in ARCHIVES and chance < 0.8:
        with contextlib.suppress(*UNREADABLE):
            return damaged_archive(rng, data)
    if suffix in XML and chance < 0.5:
        with contextlib.suppress(
            ElementTree.ParseError, LookupError
        ):  # by files that are already damaged
            return damaged_xml(rng, data)
    if suffix in (*XML, *TEXT) and chance < 0.85:
        return damaged_words(rng, data)
    return damaged_bytes(rng, data)


def damage_file(rng: random.Random, file: Path) -> None:
    """Damage a file in place."""
    file.write_bytes(damaged(rng, file.name, file.read_bytes()))
