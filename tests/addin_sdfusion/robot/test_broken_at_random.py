from __future__ import annotations

import contextlib
import copy
import tempfile
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from addin_sdfusion.robot import CardsflowError, read_robot, write_sdf
from addin_sdfusion.robot.readers import read, read_trajectory, trajectory_names

EXAMPLE = Path(__file__).parents[3] / "examples/planar_2r/robot"
NASTY = ["", " ", "nan", "inf", "-1e308 1e308 1", "1e-320", "1e999", "-1", "0", "9" * 400]
NASTY += ["world", "link_1", "link_2", "joint_1", "tip", "basic", "a\nb\tc", "é", "1 2 3", "true"]

slow = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])


def damage(data: st.DataObject, root: ElementTree.Element) -> None:
    """One defect: an element removed, doubled, moved or renamed, or a value replaced."""
    parents = [node for node in root.iter() if len(node)]
    if not parents:
        return
    parent = data.draw(st.sampled_from(parents))
    child = data.draw(st.sampled_from(list(parent)))
    action = data.draw(st.sampled_from(["remove", "double", "move", "rename", "text", "attribute"]))
    if action == "remove":
        parent.remove(child)
    elif action == "double":
        parent.append(copy.deepcopy(child))
    elif action == "move":
        parent.remove(child)
        parent.insert(0, child)
    elif action == "rename":
        child.tag = data.draw(st.sampled_from([node.tag for node in root.iter()]))
    elif action == "text":
        child.text = data.draw(st.sampled_from(NASTY))
    elif child.attrib:
        name = data.draw(st.sampled_from(sorted(child.attrib)))
        value = data.draw(st.sampled_from([None, *NASTY]))
        child.attrib.pop(name)
        if value is not None:
            child.set(name, value)


def damaged(data: st.DataObject, source: Path, target: Path) -> None:
    root = ElementTree.parse(source).getroot()
    for _ in range(data.draw(st.integers(1, 4))):
        damage(data, root)
    ElementTree.ElementTree(root).write(target, encoding="utf-8")


def survive(path):
    """Reads a robot; only the errors of this package may come out, in one line."""
    try:
        reading = read(path)
        told = [str(finding) for finding in reading.findings]
        assert reading.robot is not None or any(finding.is_error for finding in reading.findings)
    except CardsflowError as error:
        told = [str(error)]
    assert all("\n" not in line for line in told)


@slow
@given(st.data())
def test_a_damaged_caspr_robot_is_read_or_refused(data):
    with tempfile.TemporaryDirectory() as folder:
        for file in sorted(EXAMPLE.iterdir()):
            damaged(data, file, Path(folder) / file.name)
        survive(folder)
        trajectories = Path(folder) / "planar_2r_trajectories.xml"
        with contextlib.suppress(CardsflowError):
            for name in trajectory_names(trajectories):
                read_trajectory(trajectories, name)


@slow
@given(st.data())
def test_a_damaged_sdf_robot_is_read_or_refused(data):
    with tempfile.TemporaryDirectory() as folder:
        write_sdf(read_robot(EXAMPLE), folder)
        for name in ("model.sdf", "cardsflow.xml"):
            damaged(data, Path(folder) / name, Path(folder) / name)
        survive(folder)


@slow
@given(st.data())
def test_a_file_cut_or_overwritten_anywhere_is_read_or_refused(data):
    with tempfile.TemporaryDirectory() as folder:
        text = (EXAMPLE / "planar_2r_bodies.xml").read_bytes()
        at = data.draw(st.integers(0, len(text)))
        piece = data.draw(st.binary(max_size=4))
        tail = data.draw(st.sampled_from([text[at + len(piece) :], b""]))
        (Path(folder) / "a_bodies.xml").write_bytes(text[:at] + piece + tail)
        survive(folder)


@pytest.mark.parametrize("parent", ["l{before}", "l{after}", "nowhere{i}"])
def test_ten_thousand_links_are_no_burden_in_a_chain_a_loop_or_pieces(tmp_path, parent):
    count = 10_000
    parts = []
    for i in range(count):
        name = parent.format(before=i - 1, after=(i + 1) % count, i=i)
        parts.append(
            f'<link name="l{i}"/><joint name="j{i}" type="fixed"><pose relative_to="{name}"/>'
            f"<parent>{name}</parent><child>l{i}</child></joint>"
        )
    text = f'<sdf version="1.7"><model name="m">{"".join(parts)}</model></sdf>'
    (tmp_path / "model.sdf").write_text(text)
    start = time.perf_counter()
    survive(tmp_path)
    assert time.perf_counter() - start < 10.0
