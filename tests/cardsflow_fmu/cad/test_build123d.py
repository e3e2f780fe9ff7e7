"""Import of build123d assemblies: all joint types compared with build123d, and the paper's arm."""

from __future__ import annotations

import json
import math
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.designs.design_strategies import forward
from support.documents import ROOT, blocks

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.robot import InputError, Robot, read_robot
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot
from cardsflow_fmu.cad import Design, read_design
from cardsflow_fmu.cli.main import main

pytestmark = [pytest.mark.slow, pytest.mark.extra("cad")]

MARKS = ((0, 0, 0), (100, 0, 0), (0, 100, 0), (0, 0, 100))


def location(rng: np.random.Generator) -> Any:
    import build123d as b

    return b.Location(tuple(rng.uniform(-100, 100, 3)), tuple(rng.uniform(-180, 180, 3)))


KINDS = ("revolute", "referenced", "reversed", "linear", "cylindrical", "ball", "slot", "rigid")


def drawn(kind: str, seed: int, values: dict[str, Any]) -> Design:
    """Return two parts at random poses with markers, connected by a joint at given values."""
    import build123d as b

    rng = np.random.default_rng(seed)
    still, moving = b.Box(30, 40, 50), b.Box(20, 30, 60)
    still.label, moving.label = "still", "moving"
    still.locate(location(rng))
    moving.locate(location(rng))
    axis = b.Axis(tuple(rng.uniform(-50, 50, 3)), tuple(rng.normal(size=3)))
    end = b.RigidJoint("end", moving, moving.location * location(rng))
    turns, slides = (-170.0, 160.0), (-80.0, 90.0)
    if kind in ("revolute", "reversed"):
        joint = b.RevoluteJoint("q", still, axis, angular_range=turns)
    elif kind == "referenced":
        normal = axis.direction.cross(b.Vector(0, 0, 1))
        joint = b.RevoluteJoint("q", still, axis, normal, turns)
    elif kind == "linear":
        joint = b.LinearJoint("q", still, axis, slides)
    elif kind == "cylindrical":
        joint = b.CylindricalJoint("q", still, axis, linear_range=slides, angular_range=turns)
    elif kind == "ball":
        joint = b.BallJoint("q", still, location(rng), (turns, (-80.0, 80.0), turns))
    elif kind == "slot":
        end = b.RevoluteJoint("end", moving, b.Axis.Z, angular_range=turns)
        joint = b.LinearJoint("q", still, axis, slides)
    else:
        joint = b.RigidJoint("q", still, location(rng))
    if kind == "reversed":
        end.connect_to(joint, **values)
    else:
        joint.connect_to(end, **values)
    whole = b.Compound(label="both", children=[still, moving])
    design = Design(whole, density=1000.0)
    for number, mark in enumerate(MARKS):
        design.marker(f"mark_{number}", (moving, mark))
        design.marker(f"still_{number}", (still, mark))
    return design


def values_of(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    values: dict[str, Any] = {}
    if kind in ("revolute", "referenced", "reversed", "cylindrical", "slot"):
        values["angle"] = float(rng.uniform(-150.0, 150.0))
    if kind in ("linear", "cylindrical", "slot"):
        values["position"] = float(rng.uniform(-70.0, 80.0))
    if kind == "ball":
        values["angles"] = tuple(map(float, rng.uniform(-75.0, 75.0, 3)))
    return values


def coordinates(values: dict[str, Any]) -> dict[str, float]:
    """Return the robot's coordinates for joint values of build123d."""
    single = len(values) == 1
    q = {}
    if "angle" in values:
        q["q" if single else "q_rotation"] = math.radians(values["angle"])
    if "position" in values:
        q["q" if single else "q_slide"] = 0.001 * values["position"]
    for axis, angle in zip("xyz", values.get("angles", ()), strict=False):
        q[f"q_{axis}"] = math.radians(angle)
    return q


def built(design: Design) -> tuple[DesignSnapshot, Robot]:
    snapshot = design.snapshot(ExportSettings())
    made = build_robot(snapshot)
    assert made.robot is not None, made.findings
    return snapshot, made.robot


def marks(snapshot: DesignSnapshot, which: str) -> Any:
    return np.array([p.position for p in snapshot.points if p.name.startswith(which)])


@pytest.mark.cases(2)
@pytest.mark.parametrize("kind", KINDS)
def test_joints_move_parts_as_in_build123d(kind: str) -> None:
    """The robot, imported at one joint value, matches build123d at another value."""
    for seed in range(3):
        rng = np.random.default_rng(1000 + seed)
        first, second = values_of(kind, rng), values_of(kind, rng)
        _, robot = built(drawn(kind, seed, first))
        name = {"reversed": "end"}.get(kind, "q")
        initial = {c.name.replace(name, "q", 1): c.initial for c in robot.coordinates}
        assert initial == pytest.approx(coordinates(first), abs=1e-9)
        q = {c.name: coordinates(second)[c.name.replace(name, "q", 1)] for c in robot.coordinates}
        other, _ = built(drawn(kind, seed, second))
        links = {f.name: f for s in robot.task_sets for f in s.frames}
        poses = forward(robot, q)
        at = {n: (poses[f.link] @ [*f.position, 1.0])[:3] for n, f in links.items()}
        for which in ("mark", "still"):
            found = np.array([at[f"{which}_{k}"] for k in range(len(MARKS))])
            # for a reversed joint build123d moves the other part
            if kind != "reversed":
                np.testing.assert_allclose(found, marks(other, which), atol=1e-9)
        if kind == "reversed":
            apart = [forward_distance(at, k, j) for k in range(4) for j in range(4)]
            expected = {
                f"{w}_{k}": p for w in ("mark", "still") for k, p in enumerate(marks(other, w))
            }
            assert apart == pytest.approx(
                [forward_distance(expected, k, j) for k in range(4) for j in range(4)], abs=1e-9
            )
        if kind not in ("rigid", "ball"):
            assert all(c.lower < c.initial < c.upper for c in robot.coordinates)


def forward_distance(at: dict[str, Any], k: int, j: int) -> float:
    """Return the distance between markers of both parts, which does not depend on the frame."""
    return float(np.linalg.norm(at[f"mark_{k}"] - at[f"still_{j}"]))


def test_a_part_moved_after_connecting_is_rejected() -> None:
    import build123d as b

    for kind in ("revolute", "linear", "cylindrical", "slot", "rigid"):
        design = drawn(kind, 3, values_of(kind, np.random.default_rng(3)))
        moving = design._assembly.children[1]
        moving.location = b.Location((0, 0, 1)) * moving.location
        with pytest.raises(InputError, match="moved after they were connected"):
            design.snapshot(ExportSettings())


def test_points_on_nested_parts_have_the_drawn_positions() -> None:
    """The poses of a hand, an arm and the assembly are all included in the positions."""
    import build123d as b

    rng = np.random.default_rng(5)
    palm, pin = b.Box(20, 30, 40), b.Pos(7, 0, 0) * b.Cylinder(4, 50)
    palm.label, pin.label, pin.material = "palm", "pin", "mild_steel"
    palm.locate(location(rng))
    hand = b.Compound(label="hand", children=[palm, pin])
    hand.locate(location(rng))
    whole = b.Compound(label="robot", children=[hand])
    whole.locate(location(rng))
    design = Design(whole, density=1000.0)
    design.muscle("m", (palm, (1, 2, 3)), (palm, palm.faces().sort_by(b.Axis.Z)[-1]),
                  (pin, pin.faces().filter_by(b.GeomType.CYLINDER)[0]), (None, (5, 6, 7)),
                  f_max=100)  # fmt: skip
    design.wrap("w", pin, pin.faces().filter_by(b.GeomType.CYLINDER)[0], "m", 2, side=-1)
    snapshot = design.snapshot(ExportSettings())
    top = palm.faces().sort_by(b.Axis.Z)[-1].center()
    above = whole.location * hand.location
    expected = [
        (above * palm.location * b.Location((1, 2, 3))).position,
        (above * b.Location(top)).position,
        (above * pin.location).position,
        b.Vector(5, 6, 7),
    ]
    found = [point.position for point in snapshot.points]
    np.testing.assert_allclose(found, [0.001 * np.array(tuple(e)) for e in expected], atol=1e-12)
    (surface,) = snapshot.surfaces
    np.testing.assert_allclose(surface.centre, found[2], atol=1e-12)
    assert (surface.shape, surface.radius) == ("cylinder", pytest.approx(0.004))
    assert surface.length == pytest.approx(0.05)
    assert [o.path for o in snapshot.occurrences] == ["hand:1", "hand:1+palm:1", "hand:1+pin:1"]
    masses = {body.occurrence: body.mass.mass for body in snapshot.bodies if body.mass}
    assert masses["hand:1+palm:1"] == pytest.approx(1000 * 24e-6, rel=1e-12)
    assert masses["hand:1+pin:1"] == pytest.approx(7800 * math.pi * 16e-6 * 0.05, rel=1e-12)


def test_the_program_in_the_docs_creates_a_robot(tmp_path: Path) -> None:
    (block,) = (x for x in blocks(ROOT / "docs/how_to/cad.md") if x.language == "python")
    (tmp_path / "arm.py").write_text(block.text)
    design = read_design(tmp_path / "arm.py")
    made = build_robot(design)
    assert made.robot is not None, made.findings
    (shoulder,) = made.robot.coordinates
    assert shoulder.initial == pytest.approx(math.radians(20))
    assert (shoulder.damping, shoulder.tau_max) == (0.05, 4.0)
    assert [m.name for m in made.robot.muscles] == ["biceps", "triceps"]
    assert design.source.program == "build123d"


def test_two_commands_reproduce_the_papers_forces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The commands of the example succeed. The paper's motion needs 10 to 41.34 N, as published."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples/from_cad", "examples/from_cad")
    shutil.copytree(ROOT / "examples/planar_2r", "examples/planar_2r")
    text = Path("examples/from_cad/two_link_arm.py").read_text()
    commands = [line for line in text.splitlines() if line.startswith("cardsflow ")]
    assert len(commands) == 2
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0
    assert summary("results")["tracking"]["rms"] < 5e-4
    reference = 'reference={trajectory="simple_joint_motion", file="%s"}'
    file = "../examples/planar_2r/robot/planar_2r_trajectories.xml"
    gains = "controller={kp=2000.0, kd=90.0, period=0.001}"
    words = ["--set", reference % file, "--set", gains, "--set", "run.duration=8"]
    assert main(["run", "arm", "-o", "moved", *words]) == 0
    moved = summary("moved")
    assert (moved["status"], moved["infeasible_ticks"]) == ("complete", 0)
    assert moved["tracking"]["rms"] == pytest.approx(8.22e-6, rel=0.01)
    assert moved["forces"]["max"] == pytest.approx(41.34, abs=0.01)
    assert moved["forces"]["min"] == pytest.approx(10.0)
    ball = 0.4 * 0.1 * (0.3 / (4.0 * math.pi * 19300.0)) ** (2 / 3)
    link = read_robot("arm").link("link_1").inertia
    assert link.mass == pytest.approx(0.1, rel=1e-9)
    assert link.com == pytest.approx((0.0, 0.0, 0.5), abs=1e-9)
    assert (link.ixx, link.iyy, link.izz) == pytest.approx((ball,) * 3, rel=1e-9)


def summary(folder: str) -> dict[str, Any]:
    return dict(json.loads((Path(folder) / "summary.json").read_text(encoding="utf-8")))
