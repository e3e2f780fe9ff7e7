"""Randomly damaged files are read, or rejected in one line and in limited time.

The number and kind of a mutation define it completely. CARDSFLOW_MUTATIONS sets the number of
mutations (default: 500). A failure reports the number of its mutation.
"""

from __future__ import annotations

import os
import random
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from support.damaged.mutations import damaged_xml
from support.third_party_models import OSIM, URDF, WHOLE_MJCF

from addin_sdfusion.robot import (
    BasePulley,
    CableModel,
    CardsflowError,
    TaskFrame,
    TaskSet,
    Trajectory,
    TrajectoryPoint,
    caspr_losses,
    read_robot,
    write_caspr,
    write_sdf,
)
from addin_sdfusion.robot.formats.read import read, read_trajectory, trajectory_names

MENDED_OSIM = OSIM.replace("Force::", "Force_")
MUTATIONS = int(os.environ.get("CARDSFLOW_MUTATIONS", "100"))
SECONDS = 20.0
"""Maximum processor time of one mutation, far above the usual time."""

EXAMPLE = Path(__file__).parents[4] / "examples/planar_2r/robot"
MODELS = ("BMArm", "Example_planar_XY", "Example_spherical", "RoboyLeftArm")


def damaged(rng: random.Random, file: Path) -> None:
    """Return the file with one to four random defects."""
    file.write_bytes(damaged_xml(rng, file.read_bytes()))


def cut(rng: random.Random, file: Path) -> None:
    """Return the file with some bytes overwritten or truncated at a random position."""
    data = file.read_bytes()
    at = rng.randint(0, len(data))
    piece = rng.randbytes(rng.randint(0, 4))
    tail = data[at + len(piece) :] if rng.random() < 0.7 else b""
    file.write_bytes(data[:at] + piece + tail)


def read_or_reject(path: Path) -> None:
    """Read a robot; only errors of this package with one line are allowed."""
    reported = []
    try:
        reading = read(path)
        reported = [str(finding) for finding in reading.findings]
        assert reading.robot is not None or any(finding.is_error for finding in reading.findings)
        if reading.robot is not None and not any(f.is_error for f in reading.findings):
            reported += [str(finding) for finding in caspr_losses(reading.robot)]
    except CardsflowError as error:
        reported.append(str(error))
    for file in path.glob("*_trajectories.xml"):
        reported += read_or_reject_trajectories(file)
    assert all("\n" not in line and len(line) < 4000 for line in reported)


def read_or_reject_trajectories(file: Path) -> Iterator[str]:
    """Read all trajectories; only errors of this package are allowed."""
    for space in ("joint", "operational"):
        try:
            names = trajectory_names(file, space)
        except CardsflowError as error:
            yield str(error)
            continue
        for name in names:
            try:
                read_trajectory(file, name, space)
            except CardsflowError as error:
                yield str(error)


def read_all_mutations(
    count: int, sources: list[Path], mutate: Callable[[random.Random, Path], None], folder: Path
) -> None:
    """Read mutated copies of all files of the sources, in turn."""
    for number in range(count):
        rng = random.Random(f"{mutate.__name__} {number}")
        target = folder / str(number)
        shutil.copytree(sources[number % len(sources)], target)
        for file in sorted(target.iterdir()):
            if rng.random() < 0.5:
                (cut if file.suffix == ".traj" else mutate)(rng, file)
        start = time.process_time()
        try:
            read_or_reject(target)
        except Exception as error:
            raise AssertionError(f"mutation {number} is kept in {target}") from error
        assert time.process_time() - start < SECONDS, f"mutation {number}"
        shutil.rmtree(target)


SPRING = CableModel("passive_spring", (("K", 5.0), ("l0", 1.0)))
POLYNOMIAL = (("K_cable", 4e4), ("num_stiffness_polynomial_coeff", 1.0))
PULLEY = BasePulley("rotating", (("pulley_radius", (0.1,)), ("cable_entry_vector", (0, 0, 1))))
REST = (0.0, 0.0)
SAMPLES = tuple(TrajectoryPoint(0.1 * k, (1.0, -k), REST, REST) for k in range(5))
BLEND = (TrajectoryPoint(0.0, REST), TrajectoryPoint(2.0, (1.0, 2.0), blend_time=0.5))


def caspr_with_everything(folder: Path) -> Path:
    """Return the CASPR files of the example, with all supported features."""
    robot = read_robot(EXAMPLE)
    first, second, third, *others = robot.muscles
    robot = robot.with_muscles(
        [
            replace(first, pulley=PULLEY),
            replace(second, model=SPRING, f_min=0.0, f_max=0.0),
            replace(third, model=CableModel("vsd_polynomial", POLYNOMIAL)),
            *others,
        ]
    )
    (frame,) = robot.task_frames
    turn = TaskFrame("tip_orientation", frame.link, axes=("beta",))
    pose = TaskSet("pose", (frame, turn))
    robot = replace(robot, task_sets=(*robot.task_sets, pose), task_set="pose")
    file = EXAMPLE / "planar_2r_trajectories.xml"
    trajectories = [read_trajectory(file, name) for name in trajectory_names(file)]
    trajectories.append(Trajectory("samples", "samples", SAMPLES, 0.1))
    trajectories.append(Trajectory("blend", "parabolic_blend", BLEND, 0.1))
    trajectories.append(replace(trajectories[0], name="reach", space="operational"))
    write_caspr(robot, folder, trajectories=trajectories)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("mutate", [damaged, cut])
def test_damaged_caspr_robot_is_read_or_rejected(tmp_path, mutate):
    sources = [caspr_with_everything(tmp_path / "example")]
    read_all_mutations(MUTATIONS // 5, sources, mutate, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("mutate", [damaged, cut])
def test_damaged_published_caspr_model_is_read_or_rejected(shared, tmp_path, mutate):
    sources = [shared / "robots/caspr" / model for model in MODELS]
    read_all_mutations(MUTATIONS // 5, sources, mutate, tmp_path)


@pytest.mark.slow
def test_damaged_sdf_robot_is_read_or_rejected(tmp_path):
    write_sdf(read_robot(EXAMPLE), tmp_path / "example")
    read_all_mutations(MUTATIONS // 5, [tmp_path / "example"], damaged, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "text"),
    [("arm.urdf", URDF), ("leg.osim", MENDED_OSIM), ("model.xml", WHOLE_MJCF)],
    ids=["urdf", "osim", "mjcf"],
)
def test_damaged_third_party_model_is_read_or_rejected(tmp_path, name, text):
    """CARDSFLOW_MUTATIONS=20000 takes three minutes; a child process compiles each MJCF file."""
    (tmp_path / "example").mkdir()
    (tmp_path / "example" / name).write_text(text)
    count = MUTATIONS // (9 if text is WHOLE_MJCF else 3)
    for mutate in (damaged, cut):
        read_all_mutations(count, [tmp_path / "example"], mutate, tmp_path)


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("parent", ["l{before}", "l{after}", "nowhere{i}"])
def test_ten_thousand_links_are_read_in_time(tmp_path, parent):
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
    read_or_reject(tmp_path)
