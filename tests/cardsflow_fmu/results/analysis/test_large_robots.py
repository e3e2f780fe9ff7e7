"""The work on large robots grows linearly, or they are rejected."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Inertia, InputError, Joint, Link, Robot, limits, read_robot
from addin_sdfusion.robot.transforms.joint_chains import Names
from cardsflow_fmu.results.analysis.info import robot_info
from sim_dart.core.blob import compile_blob

BODY = '<geom type="sphere" size="0.1" mass="1"/>'
SITES = '<site name="base" pos=".1 0 .1"/>'


def _joints(n: int) -> str:
    return "".join(
        f'<body name="b{k}" pos="0 0 {k}"><joint name="j{k}" axis="0 1 0" range="-1 1" '
        f'limited="true"/>{BODY}<site name="s{k}" pos=".1 0 0"/></body>'
        for k in range(n)
    )


def _connects(n: int) -> str:
    return "".join(f'<connect body1="b{k}" body2="b{k - 1}" anchor="0 0 0"/>' for k in range(1, n))


def _muscles(n: int) -> str:
    return "".join(
        f'<spatial name="t{k}"><site site="base"/><site site="s{k}"/></spatial>' for k in range(n)
    )


EXTRAS: dict[str, Callable[[int], str]] = {
    "joints": lambda n: "",
    "loops": lambda n: f"<equality>{_connects(n)}</equality>",
    "one tendon of all joints": lambda n: (
        '<tendon><fixed name="t">'
        + "".join(f'<joint joint="j{k}" coef="1"/>' for k in range(n))
        + '</fixed></tendon><actuator><motor tendon="t"/></actuator>'
    ),
    "muscles": lambda n: (
        f"<tendon>{_muscles(n)}</tendon><actuator>"
        + "".join(f'<motor tendon="t{k}" ctrlrange="-10 0"/>' for k in range(n))
        + "</actuator>"
    ),
}


def _written(file: Path, n: int, extra: str) -> Path:
    text = f"<worldbody>{SITES}{_joints(n)}</worldbody>{extra}"
    file.write_text(f'<mujoco model="m">{text}</mujoco>', encoding="utf-8")
    return file


def _calls(act: Callable[[], object]) -> int:
    """Return the number of Python functions that are called."""
    count = 0

    def note(frame: FrameType, event: str, argument: Any) -> None:
        nonlocal count
        count += event == "call"

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        act()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize("kind", EXTRAS)
def test_work_on_a_robot_grows_linearly_with_its_size(tmp_path: Path, kind: str) -> None:
    small = _written(tmp_path / "small.xml", 20, EXTRAS[kind](20))
    large = _written(tmp_path / "large.xml", 80, EXTRAS[kind](80))
    robot_info(small)
    few, many = (_calls(lambda file=file: robot_info(file)) for file in (small, large))
    assert many < 4.4 * few


def test_a_robot_is_checked_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from addin_sdfusion.robot.checks import check as checks

    runs: list[Robot] = []
    first = checks.CHECKS[0]
    noted = (lambda robot: runs.append(robot) or first(robot), *checks.CHECKS[1:])
    monkeypatch.setattr(checks, "CHECKS", noted)
    robot_info(_written(tmp_path / "robot.xml", 3, ""))
    assert len(runs) == 1


class _Name(str):
    """Name that counts its comparisons."""

    compared = 0
    __hash__ = str.__hash__

    def __eq__(self, other: object) -> bool:
        _Name.compared += 1
        return str.__eq__(self, other)


def test_links_are_found_without_a_search() -> None:
    names = [_Name(f"link_{k}") for k in range(100)]
    links = tuple(Link(name, Inertia(1.0)) for name in names)
    robot = Robot("many", links, tuple(Joint(str(n), "world", n, (), ()) for n in names))
    _Name.compared = 0
    assert [robot.link(str(name)) for name in names] == list(links)
    assert _Name.compared < 10 * len(names)


def test_first_of_two_links_with_the_same_name_is_found() -> None:
    links = Link("arm", Inertia(1.0)), Link("arm", Inertia(2.0))
    assert Robot("two", links, ()).link("arm") is links[0]


def test_names_of_many_similar_parts_stay_short() -> None:
    names = Names(["arm"])
    given = [names.unique("arm") for _ in range(1000)]
    assert len(set(given)) == 1000
    assert "arm" not in given
    assert max(map(len, given)) < 20


def test_limits_apply_to_all_files_of_a_robot_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = "".join(f'<include file="part{k}.xml"/>' for k in range(3))
    for k in range(3):
        body = f'<body name="b{k}"><joint name="j{k}"/>{BODY}</body>'
        text = f"<mujocoinclude>{body}</mujocoinclude>"
        (tmp_path / f"part{k}.xml").write_text(text, encoding="utf-8")
    text = f"<mujoco><worldbody>{parts}</worldbody></mujoco>"
    (tmp_path / "main.xml").write_text(text, encoding="utf-8")
    assert len(read_robot(tmp_path / "main.xml").links) == 3
    monkeypatch.setattr("addin_sdfusion.robot.formats.reading.xml.XML_ELEMENTS", 12)
    with pytest.raises(InputError, match="more than 12 elements in total, with the other files"):
        read_robot(tmp_path / "main.xml")


def test_too_large_matrices_are_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "MATRIX", 7)
    with pytest.raises(InputError, match="2 coordinates and 4 muscles are too many"):
        compile_blob(planar_2r())
