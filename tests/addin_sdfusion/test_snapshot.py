"""Tests of snapshot files: they are read back unchanged, and damaged files are rejected."""

from __future__ import annotations

import base64
import contextlib
import json
import math
import zlib
from array import array
from pathlib import Path
from typing import Any

import fake_fusion
import jsonschema
import pytest
from fake_fusion import designs
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.robot import limits
from addin_sdfusion.robot.errors import InputError
from addin_sdfusion.robot.finding import Finding, Subject
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    BodySnapshot,
    CouplingSnapshot,
    DesignSnapshot,
    GroupSnapshot,
    JointSnapshot,
    MassSnapshot,
    MeshSnapshot,
    MotionSnapshot,
    MuscleSnapshot,
    OccurrenceSnapshot,
    PointSnapshot,
    PointUse,
    SourceSnapshot,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)
from addin_sdfusion.snapshot_file import (
    FORMAT,
    file_schema,
    read_snapshot,
    snapshot_text,
    write_snapshot,
)

NUMBERS = st.floats(-1e300, 1e300)
LIMITS = st.one_of(st.none(), NUMBERS, st.sampled_from([math.inf, -math.inf]))
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS)
TEXTS = st.text(max_size=12)
PATHS = st.one_of(st.none(), st.just(Path("a/b.xml")))

MASSES = st.builds(MassSnapshot, NUMBERS, VECTORS, st.tuples(*[NUMBERS] * 6), VECTORS)
MESHES = st.builds(
    MeshSnapshot,
    st.lists(st.floats(allow_nan=False), max_size=9).map(lambda v: array("d", v)),
    st.lists(st.integers(-(2**31), 2**31 - 1), max_size=9).map(lambda v: array("i", v)),
)
MOTIONS = st.builds(
    MotionSnapshot,
    st.sampled_from(["rotation", "translation"]),
    VECTORS,
    NUMBERS,
    LIMITS,
    LIMITS,
    TEXTS,
)
BODIES = st.builds(
    BodySnapshot,
    TEXTS,
    TEXTS,
    mass=st.one_of(st.none(), MASSES),
    mesh=st.one_of(st.none(), MESHES),
    kind=st.sampled_from(["solid", "surface", "mesh"]),
)
JOINTS = st.builds(
    JointSnapshot,
    TEXTS,
    st.sampled_from(["rigid", "ball", "pin_slot", "inferred"]),
    origin_one=st.one_of(st.none(), VECTORS),
    origin_two=st.one_of(st.none(), VECTORS),
    motions=st.lists(MOTIONS, max_size=3).map(tuple),
)
OCCURRENCES = st.builds(OccurrenceSnapshot, TEXTS, mass=st.one_of(st.none(), MASSES))
WRAPS = st.builds(WrapUse, TEXTS, st.integers(0, 9), side=st.sampled_from([-1, 0, 1]))
POINT_USES = st.builds(PointUse, st.sampled_from(["via", "task", "marker"]), TEXTS, TEXTS)
SURFACE_USES = st.builds(SurfaceUse, TEXTS, TEXTS, st.lists(WRAPS, max_size=2).map(tuple))
POINTS = st.builds(
    PointSnapshot, TEXTS, TEXTS, VECTORS, use=st.one_of(st.none(), POINT_USES), problem=TEXTS
)
MUSCLES = st.builds(
    MuscleSnapshot,
    TEXTS,
    st.sampled_from(["#012def", "#ABCDEF"]),
    f_max=st.one_of(NUMBERS, st.just(math.inf)),
    model=st.sampled_from(["ideal", "hill_thelen2003"]),
    parameters=st.dictionaries(TEXTS, NUMBERS, max_size=3),
)
SURFACES = st.builds(
    SurfaceSnapshot,
    TEXTS,
    st.sampled_from(["sphere", "cylinder"]),
    NUMBERS,
    VECTORS,
    VECTORS,
    NUMBERS,
    use=st.one_of(st.none(), SURFACE_USES),
)
FINDINGS = st.builds(Finding, subject=st.builds(Subject, TEXTS, TEXTS), file=PATHS)
SNAPSHOTS = st.builds(
    DesignSnapshot,
    TEXTS,
    st.builds(ExportSettings),
    st.lists(OCCURRENCES, max_size=3).map(tuple),
    st.lists(BODIES, max_size=2).map(tuple),
    st.lists(st.builds(GroupSnapshot), max_size=2).map(tuple),
    st.lists(JOINTS, max_size=2).map(tuple),
    st.lists(POINTS, max_size=2).map(tuple),
    st.lists(SURFACES, max_size=2).map(tuple),
    st.lists(MUSCLES, max_size=2).map(tuple),
    st.sampled_from(["part", "assembly", "hybrid", "unknown"]),
    st.lists(FINDINGS, max_size=2).map(tuple),
    st.builds(SourceSnapshot, TEXTS, TEXTS, TEXTS),
    st.lists(st.builds(CouplingSnapshot, TEXTS, TEXTS, NUMBERS), max_size=2).map(tuple),
)


@pytest.fixture
def snapshot() -> DesignSnapshot:
    with fake_fusion.install():
        from addin_sdfusion.fusion.design import read_design

        return read_design(designs.things_to_pick())


def plain(snapshot: DesignSnapshot) -> dict[str, Any]:
    return dict(json.loads(snapshot_text(snapshot)))


def refused(tmp_path: Path, content: Any) -> InputError:
    """Return the error for the content of a file."""
    file = tmp_path / "snapshot.json"
    text = content if isinstance(content, str) else json.dumps(content)
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_snapshot(file)
    assert caught.value.file == file
    assert "\n" not in str(caught.value)
    return caught.value


@pytest.mark.slow
@given(SNAPSHOTS)
def test_snapshot_is_read_back_unchanged(
    tmp_path_factory: pytest.TempPathFactory, made: Any
) -> None:
    file = write_snapshot(made, tmp_path_factory.mktemp("s") / "folder" / "snapshot.json")
    back = read_snapshot(file)
    assert back == made
    assert snapshot_text(back) == snapshot_text(made)
    for body, other in zip(back.bodies, made.bodies, strict=True):
        if body.mesh is not None:
            assert body.mesh.nodes.typecode == other.mesh.nodes.typecode
            assert body.mesh.nodes.tobytes() == other.mesh.nodes.tobytes()


def test_text_is_the_same_every_time_and_plain_ascii(snapshot: DesignSnapshot) -> None:
    text = snapshot_text(snapshot)
    assert text == snapshot_text(snapshot)
    assert text.isascii()
    assert json.loads(text).keys() == {"format", "design"}


def test_schema_accepts_written_snapshots() -> None:
    """All designs of the fake Fusion are checked."""
    validator = jsonschema.Draft202012Validator(file_schema())
    with fake_fusion.install():
        from addin_sdfusion.fusion.design import read_design

        for make in designs.FEATURES.values():
            validator.validate(json.loads(snapshot_text(read_design(make(), meshes=False))))
        validator.validate(json.loads(snapshot_text(read_design(designs.two_link_arm()))))


@pytest.mark.slow
def test_other_files_are_rejected(tmp_path: Path) -> None:
    for content in ("", "{", "[]", "7", "null", '{"design": {}}', "[" * 100_000, "\x00"):
        assert refused(tmp_path, content).key is None
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not JSON"):
        read_snapshot(tmp_path / "binary.json")
    with pytest.raises(InputError, match="cannot be read"):
        read_snapshot(tmp_path / "missing.json")
    with pytest.raises(InputError, match="folder"):
        read_snapshot(tmp_path)


@pytest.mark.parametrize("version", [0, FORMAT + 1, "1", None, 1.5, [1], True, 1.0])
def test_unknown_formats_are_rejected(
    tmp_path: Path, snapshot: DesignSnapshot, version: Any
) -> None:
    error = refused(tmp_path, plain(snapshot) | {"format": version})
    assert error.key == "format"
    assert str(FORMAT) in error.problem


CHANGES: list[tuple[tuple[Any, ...], Any, str]] = [
    (("name",), 7, "design.name"),
    (("colour",), "red", "design"),
    (("intent",), "robot", "design.intent"),
    (("intent",), [], "design.intent"),
    (("joints",), {}, "design.joints"),
    (("joints", 0), [], "design.joints[0]"),
    (("joints", 0, "kind"), "weld", "design.joints[0].kind"),
    (("joints", 0, "origin_one"), [1, 2], "design.joints[0].origin_one"),
    (("joints", 0, "origin_one"), [1, 2, "x"], "design.joints[0].origin_one[2]"),
    (("joints", 0, "motions", 0, "axis"), [1, 2, 10**400], "design.joints[0].motions[0].axis[2]"),
    (("joints", 0, "motions", 0, "axis"), [1, True, 0], "design.joints[0].motions[0].axis[1]"),
    (("occurrences", 1, "grounded"), 1, "design.occurrences[1].grounded"),
    (("occurrences", 0, "mass", "mass"), None, "design.occurrences[0].mass.mass"),
    (("bodies", 0, "mesh"), 3, "design.bodies[0].mesh"),
    (("bodies", 0, "mesh", "nodes"), [1.0], "design.bodies[0].mesh.nodes"),
    (("bodies", 0, "mesh", "nodes", "type"), "q", "design.bodies[0].mesh.nodes"),
    (("bodies", 0, "mesh", "nodes", "type"), "i", "design.bodies[0].mesh.nodes"),
    (("bodies", 0, "mesh", "triangles", "type"), "d", "design.bodies[0].mesh.triangles"),
    (("bodies", 0, "mesh", "nodes", "zlib"), 5, "design.bodies[0].mesh.nodes"),
    (("muscles",), [{"name": "m", "parameters": {"k": "x"}}], "design.muscles[0].parameters.k"),
    (("muscles",), [{"name": "m", "color": "red"}], "design.muscles[0].color"),
    (
        ("points",),
        [{"name": "p", "occurrence": "", "position": [0, 0, 0], "use": {"role": "eye"}}],
        "design.points[0].use.role",
    ),
    (("settings",), {"quality": "superb"}, "design.settings.quality"),
]


@pytest.mark.parametrize(("where", "value", "key"), CHANGES)
def test_message_contains_the_key(
    tmp_path: Path, snapshot: DesignSnapshot, where: Any, value: Any, key: str
) -> None:
    content = plain(snapshot)
    at = content["design"]
    for step in where[:-1]:
        at = at[step]
    at[where[-1]] = value
    assert refused(tmp_path, content).key == key


def test_missing_key_is_reported(tmp_path: Path, snapshot: DesignSnapshot) -> None:
    content = plain(snapshot)
    del content["design"]["bodies"][0]["name"]
    error = refused(tmp_path, content)
    assert error.key == "design.bodies[0]"
    assert "'name'" in error.problem


def packed(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


@pytest.mark.parametrize(
    "damaged",
    [
        "not base64!",
        "AAA",
        packed(b"no zlib at all"),
        packed(zlib.compress(b"1234567")),  # not a multiple of the item size
        packed(zlib.compress(bytes(8000))[:-5]),  # truncated
        packed(zlib.compress(bytes(8000))[:-1] + b"\x00"),  # wrong checksum
    ],
)
def test_damaged_numbers_are_rejected(
    tmp_path: Path, snapshot: DesignSnapshot, damaged: str
) -> None:
    content = plain(snapshot)
    content["design"]["bodies"][0]["mesh"]["nodes"]["zlib"] = damaged
    error = refused(tmp_path, content)
    assert error.key == "design.bodies[0].mesh.nodes"
    assert "packed" in error.problem


@pytest.mark.slow
@given(SNAPSHOTS, st.data())
def test_any_flipped_byte_is_read_or_rejected(
    tmp_path_factory: pytest.TempPathFactory, made: DesignSnapshot, data: st.DataObject
) -> None:
    text = bytearray(snapshot_text(made), encoding="ascii")
    for _ in range(data.draw(st.integers(1, 3))):
        text[data.draw(st.integers(0, len(text) - 1))] = data.draw(st.integers(0, 255))
    file = tmp_path_factory.getbasetemp() / "flipped.json"
    file.write_bytes(text)
    with contextlib.suppress(InputError):  # no other error may be raised
        read_snapshot(file)


def test_decompression_bombs_are_rejected(
    tmp_path: Path, snapshot: DesignSnapshot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A few bytes that expand to more than the limit are not completely decompressed."""
    monkeypatch.setattr(limits, "SNAPSHOT_UNPACKED", 2**16)
    content = plain(snapshot)
    content["design"]["bodies"][0]["mesh"]["nodes"]["zlib"] = packed(zlib.compress(bytes(2**24)))
    error = refused(tmp_path, content)
    assert error.key == "design.bodies[0].mesh.nodes"
    assert "too many" in error.problem


def test_total_decompressed_size_is_limited(
    tmp_path: Path, snapshot: DesignSnapshot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The total decompressed size of a file is limited."""
    monkeypatch.setattr(limits, "SNAPSHOT_UNPACKED", 2**16)
    content = plain(snapshot)
    body = content["design"]["bodies"][0]
    body["mesh"]["nodes"]["zlib"] = packed(zlib.compress(bytes(2**14)))
    content["design"]["bodies"] = [body] * 3
    (tmp_path / "s.json").write_text(json.dumps(content))
    assert len(read_snapshot(tmp_path / "s.json").bodies) == 3
    content["design"]["bodies"] = [body] * 5
    error = refused(tmp_path, content)
    assert error.key.startswith("design.bodies[")
    assert "too many" in error.problem


def test_a_file_that_is_too_large_is_not_read(
    tmp_path: Path, snapshot: DesignSnapshot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is not written either, because it could not be read again."""
    monkeypatch.setattr(limits, "SNAPSHOT", 1000)
    assert "larger than" in refused(tmp_path, " " * 2000).problem
    with pytest.raises(InputError, match="larger than"):
        write_snapshot(snapshot, tmp_path / "large.json")
    assert not (tmp_path / "large.json").exists()


def test_a_file_with_too_many_values_is_not_parsed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "SNAPSHOT_VALUES", 1000)
    assert "more than 1000 values" in refused(tmp_path, [0] * 2000).problem
