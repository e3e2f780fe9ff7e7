"""Tests of the table of native laws in joint space, and of the list generated from it."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import UnknownNameError
from controllers import JointSpaceController
from controllers.laws import joint_laws
from controllers.laws.joint_laws import CSRC, JOINT_LAWS, JointLaw, c_list
from sim_dart import DartDynamics


def _tree(folder: Path, *laws: str) -> Path:
    """Create a source tree with the C files of laws."""
    (folder / CSRC).mkdir(parents=True)
    for law in laws:
        (folder / CSRC / f"{law}.c").touch()
    return folder


def test_list_in_c_matches_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        joint_laws, "JOINT_LAWS", (JointLaw("b", ""), JointLaw("a", "", True, True))
    )
    lines = c_list(_tree(tmp_path, "a", "b")).splitlines()
    assert [line.removesuffix("\\").strip() for line in lines[2:]] == [
        "JOINT_LAW(b, 0)",
        "JOINT_LAW(a, 1)",
    ]


def test_law_without_file_and_file_without_law_raise_errors(tmp_path: Path) -> None:
    first, *others = (law.name for law in JOINT_LAWS)
    with pytest.raises(ValueError, match=f"joint has no file for the law '{first}'"):
        c_list(_tree(tmp_path / "lacks", *others))
    with pytest.raises(ValueError, match=r"joint_laws.py has no law 'more'"):
        c_list(_tree(tmp_path / "has", first, *others, "more"))


def test_controller_selects_a_law_by_name() -> None:
    dynamics = DartDynamics(planar_2r())
    for law in JOINT_LAWS:
        JointSpaceController(dynamics, 1.0, 1.0, law=law.name)
    with pytest.raises(UnknownNameError, match=r"lyapunow.*lyapunov"):
        JointSpaceController(dynamics, 1.0, 1.0, law="lyapunow")
