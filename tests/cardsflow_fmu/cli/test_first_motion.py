"""`cardsflow init` and `run` for robots without tuning: a motion that the muscles can perform."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.cases import sample_cases
from support.command_line import CommandLine
from support.robots.loops import four_bar
from support.robots.one_link import cable, one_link

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    InputError,
    Joint,
    Link,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    revolute,
    write_sdf,
)
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings import robots
from cardsflow_fmu.experiment.template import ExperimentDraft
from cardsflow_fmu.results.analysis.first_motion import first_motion
from cardsflow_fmu.simulation import draft_search
from cardsflow_fmu.simulation.draft_search import DraftSearch
from cardsflow_fmu.simulation.starter import init
from sim_dart import CoreDynamics, close_loops

Y = (0.0, 1.0, 0.0)
ABOVE, BELOW = (-0.1, 0.0, 0.5), (-0.1, 0.0, -0.5)
LIGHT = Inertia(1.0, (0.2, 0.0, 0.0), 0.01, 0.01, 0.01)


def strands(*roots: tuple[float, float, float], f_max: float = np.inf) -> list[Muscle]:
    return [
        replace(cable(root, (0.3, 0.0, 0.0), f_max=f_max), name=f"strand {k}")
        for k, root in enumerate(roots)
    ]


def arm(*muscles: Muscle) -> Robot:
    """Return a horizontal link of 1 kg on a hinge."""
    return one_link(LIGHT, muscles, motions=revolute(Y), lower=-1.0, upper=1.0)


def two_links(*muscles: Muscle) -> Robot:
    """Return an arm with a second link on a hinge at the end of the first."""
    robot = arm(*muscles)
    wrist = Joint("wrist", "a", "hand", revolute(Y), (Coordinate("wrist"),))
    return replace(robot, links=(*robot.links, Link("hand", LIGHT)), joints=(*robot.joints, wrist))


def init_and_run(robot: Robot, folder: Path, cardsflow: CommandLine) -> tuple[dict, str]:
    """Run `init`, then the experiment; return the summary of the run and the output of `init`."""
    write_sdf(robot, folder / "robot")
    code, out, err = cardsflow("init", folder / "robot", "-o", folder)
    assert code == 0, err
    assert out.startswith(str(folder / "experiment.toml"))
    code, _, problem = cardsflow(
        "run", folder, "--coupling", "direct", "-o", folder / "out", "--strict"
    )
    assert code == 0, problem
    return json.loads((folder / "out/summary.json").read_text()), err


def assert_tracks(summary: dict) -> None:
    assert summary["infeasible_ticks"] == 0
    assert summary["tracking"]["max"] < 1e-3


@pytest.mark.slow
def test_motion_is_limited_by_the_force_limits(tmp_path: Path, cardsflow: CommandLine) -> None:
    strong = arm(*strands(ABOVE, f_max=100.0))
    dynamics = CoreDynamics(strong)
    held = [-dynamics.gravity([q])[0] / dynamics.muscle_jacobian([q])[0, 0] for q in (-0.06, 0.06)]
    (strand,) = strong.muscles
    narrow = arm(replace(strand, f_min=float(min(held)), f_max=float(max(held))))
    motion = first_motion(narrow)
    assert 0.0 < abs(motion.end[0] - motion.start[0]) < 0.06
    summary, err = init_and_run(narrow, tmp_path, cardsflow)
    assert_tracks(summary)
    assert "no room" not in err


@pytest.mark.slow
def test_missing_force_limits_are_suggested(tmp_path: Path, cardsflow: CommandLine) -> None:
    summary, err = init_and_run(arm(*strands(ABOVE)), tmp_path, cardsflow)
    assert_tracks(summary)
    data = tomllib.loads((tmp_path / "experiment.toml").read_text())
    f_max = data["muscles"]["strand 0"]["f_max"]
    assert summary["forces"]["max"] < f_max < 10.0 * summary["forces"]["max"]
    assert f"it is set to {f_max:g} N" in err


@pytest.mark.slow
@pytest.mark.parametrize(("apart", "meets"), [(0.01, False), (0.002, True)])
def test_colliding_muscles_are_avoided_or_reported(
    apart: float, meets: bool, tmp_path: Path
) -> None:
    """Cables are above and below the middle of a strand that moves by 15 mm at 0.1 rad."""
    middle = 0.5 * np.add(ABOVE, (0.3, 0.0, 0.0))
    across = [
        Muscle(name, tuple(ViaPoint(WORLD, (middle[0], y, middle[2] + z)) for y in (-1.0, 1.0)))
        for name, z in (("over", apart), ("under", -apart))
    ]
    write_sdf(arm(*strands(ABOVE, BELOW), *across), tmp_path / "robot")
    starter = init(tmp_path / "robot", tmp_path)
    assert any("'strand 0' comes within" in note for note in starter.notes) == meets
    curve = Experiment.load(starter.file).reference.curve
    assert abs(curve.points[1].q[0] - curve.points[0].q[0]) == pytest.approx(0.1 if meets else 0.05)
    assert tomllib.loads(starter.file.read_text())["muscles"].keys() == {"*"}


@pytest.mark.slow
def test_start_pose_of_a_hanging_link_can_be_held_by_its_muscle(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    """A single strand pulls the hanging link to one side; the start must be on this side."""
    robot = arm(*strands((-0.5, 0.0, -0.1)))
    hanging = replace(robot.joints[0].coordinates[0], lower=0.0, upper=3.0, initial=1.9)
    robot = replace(robot, joints=(replace(robot.joints[0], coordinates=(hanging,)),))
    summary, _ = init_and_run(robot, tmp_path, cardsflow)
    assert_tracks(summary)
    experiment = Experiment.load(tmp_path)
    dynamics = CoreDynamics(experiment.robot)
    q = np.array(experiment.start.q)
    assert float(dynamics.gravity(q)[0] * -dynamics.muscle_jacobian(q)[0, 0]) > 0.0


@pytest.mark.slow
def test_coordinate_without_muscle_is_locked_and_reported(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    summary, err = init_and_run(two_links(*strands(ABOVE, BELOW)), tmp_path, cardsflow)
    assert_tracks(summary)
    assert "wrist is locked at 0: no muscle drives it" in err
    text = (tmp_path / "experiment.toml").read_text()
    assert tomllib.loads(text)["robot"]["coordinates"] == {"wrist": {"locked": 0.0}}
    assert "no muscle drives it" in text
    assert list(summary["tracking"]["per_signal"]) == ["q.q"]


@pytest.mark.slow
def test_commented_spring_can_replace_a_lock(tmp_path: Path, cardsflow: CommandLine) -> None:
    init_and_run(two_links(*strands(ABOVE, BELOW)), tmp_path, cardsflow)
    file = tmp_path / "experiment.toml"
    lines = [line for line in file.read_text().splitlines() if "wrist.locked" not in line]
    springs = ("# coordinates.wrist", "# passive.wrist")
    lines = [x.removeprefix("# ") if x.startswith(springs) else x for x in lines]
    file.write_text("\n".join(lines))
    code, out, err = cardsflow(
        "run", tmp_path, "--coupling", "direct", "-o", tmp_path / "sprung", "--strict"
    )
    assert code == 0, out + err
    summary = json.loads((tmp_path / "sprung/summary.json").read_text())
    assert_tracks(summary)
    assert list(summary["tracking"]["per_signal"]) == ["q.q"]
    table = (tmp_path / "sprung/results.csv").read_text().splitlines()
    column = table[0].split(",").index("q.wrist")
    assert np.ptp([float(row.split(",")[column]) for row in table[1:]]) > 1e-3
    assert cardsflow.json("check", tmp_path) == [] or not [
        f
        for f in cardsflow.json("check", tmp_path)
        if f["code"].startswith(("pose", "coord", "mo"))
    ]


@pytest.mark.slow
def test_motion_stays_within_joint_and_force_limits(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = arm(*strands(ABOVE, BELOW, f_max=60.0))
    near = replace(robot.joints[0].coordinates[0], lower=0.0, upper=0.05)
    robot = replace(robot, joints=(replace(robot.joints[0], coordinates=(near,)),))
    summary, _ = init_and_run(robot, tmp_path, cardsflow)
    assert_tracks(summary)
    assert summary["forces"]["max"] < 60.0
    reference = Experiment.load(tmp_path).reference.curve
    positions = [point.q[0] for point in reference.points]
    assert min(positions) > 0.0
    assert max(positions) < 0.05
    assert np.ptp(positions) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("roots", "f_max", "words"),
    [
        (
            (BELOW,),
            np.inf,
            "no muscle produces negative torque at q",
        ),  # q > 0 rotates the link downwards
        ((ABOVE,), 1.0, "too weak; `cardsflow size` computes the required forces"),
    ],
)
def test_robot_that_muscles_cannot_hold_is_rejected_with_a_reason(
    roots: tuple, f_max: float, words: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    robot = arm(*strands(*roots, f_max=f_max))
    narrow = replace(robot.joints[0].coordinates[0], lower=-0.3, upper=0.3)
    robot = replace(robot, joints=(replace(robot.joints[0], coordinates=(narrow,)),))
    write_sdf(robot, tmp_path / "robot")
    message = cardsflow.error_line("init", tmp_path / "robot", "-o", tmp_path)
    assert "the muscles cannot hold the robot in any pose" in message
    assert words in message
    assert not (tmp_path / "experiment.toml").exists()


def test_too_large_length_is_rejected(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = two_links(*strands(ABOVE, BELOW))
    wrist = replace(robot.joints[-1], T_parent_joint=Pose((1e200, 0.0, 0.0)))
    write_sdf(replace(robot, joints=(*robot.joints[:-1], wrist)), tmp_path)
    code, _, error = cardsflow("init", str(tmp_path), "-o", str(tmp_path / "out"))
    assert code == 2
    assert "a length, mass or force of the robot is too large" in error.splitlines()[-1]
    code, out, error = cardsflow("check", str(tmp_path))
    assert "a length, mass or force of the robot is too large; the robot can be" in out
    assert error == ""


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("length", "mass"),
    sample_cases([(10.0, 1e3), (1e-2, 1.0), (1e-3, 1e-3)]),
    ids=["10 m", "cm", "mm"],
)
def test_robots_of_any_size_have_a_first_motion(
    length: float, mass: float, tmp_path: Path, cardsflow: CommandLine
) -> None:
    def scaled(point: tuple[float, float, float]) -> tuple[float, float, float]:
        return tuple(length * x for x in point)  # type: ignore[return-value]

    inertia = Inertia(mass, scaled((0.2, 0.0, 0.0)), *[0.01 * mass * length**2] * 3)
    muscles = [
        replace(m, via_points=tuple(ViaPoint(p.link, scaled(p.position)) for p in m.via_points))
        for m in strands(ABOVE, BELOW)
    ]
    robot = arm(*muscles)
    robot = replace(robot, links=(replace(robot.links[0], inertia=inertia),))
    summary, _ = init_and_run(robot, tmp_path, cardsflow)
    assert_tracks(summary)


@pytest.mark.slow
def test_massless_motions_are_locked(tmp_path: Path, cardsflow: CommandLine) -> None:
    """A rod on a ball joint has no inertia about its axis."""
    rod = Inertia(1.0, (0.2, 0.0, 0.0), 0.0, 0.01, 0.01)
    x, y = (1.0, 0.0, 0.0), Y
    motions = (*revolute(y), replace(revolute(x)[0], coordinate=1))
    joint = Joint("j", WORLD, "a", motions, (Coordinate("swing"), Coordinate("twist")))
    points = [(0.3, 0.0, 0.05), (0.3, 0.0, -0.05)]
    muscles = tuple(
        Muscle(f"m{k}", (ViaPoint(WORLD, root), ViaPoint("a", point)), 0.0, 100.0)
        for k, (root, point) in enumerate(
            (root, point) for root in (ABOVE, BELOW) for point in points
        )
    )
    tip = Link("tip", Inertia(0.1, (0.0, 0.0, 0.0), 0.0, 1e-3, 1e-3))
    end = Joint("end", "a", "tip", revolute(y), (Coordinate("end", lower=0.0, upper=1e-6),))
    robot = Robot("rod", (Link("a", rod), tip), (joint, end), (CableSet("all", muscles),), "all")
    write_sdf(robot, tmp_path / "robot")
    code, _, err = cardsflow("init", tmp_path / "robot", "-o", tmp_path)
    assert code == 0, err
    assert "it moves no mass" in err


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    sample_cases(["cardsflow/shoulder_testbed", "cardsflow/theClaw", "caspr/CAREX", "caspr/BMArm"]),
)
def test_published_robots_track_the_first_motion(
    name: str, shared: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    code, _, err = cardsflow("init", shared / "robots" / name, "-o", tmp_path)
    assert code == 0, err
    code, out, _ = cardsflow("run", tmp_path, "--coupling", "direct", "--json", "--strict")
    assert code == 0
    assert_tracks(json.loads(out))


@pytest.mark.slow
def test_names_in_other_scripts_remain_distinct(tmp_path: Path, cardsflow: CommandLine) -> None:
    muscles = [
        replace(muscle, name=name)
        for muscle, name in zip(strands(ABOVE, BELOW, f_max=300.0), ("肌", "腱"), strict=True)
    ]
    summary, _ = init_and_run(arm(*muscles), tmp_path, cardsflow)
    assert_tracks(summary)
    assert list(summary["forces"]["per_muscle"]) == ["f.u808c", "f.u8171"]
    same = [replace(m, name=name) for m, name in zip(muscles, ("a b", "a_b"), strict=True)]
    write_sdf(arm(*same), tmp_path / "same")
    said = cardsflow.error_line("init", tmp_path / "same", "-o", tmp_path / "same.toml")
    what = "'a b' and 'a_b' would both be the variable 'f.a_b'; rename one"
    assert said.strip() == f"cardsflow: {tmp_path / 'same'}: first experiment: robot.path: {what}"


@pytest.mark.slow
def test_joint_friction_is_compensated_and_reported(tmp_path: Path, cardsflow: CommandLine) -> None:
    """The friction equals 2.5 rad/s² of the arm; feedback alone has an error of 6 mrad."""
    robot = arm(*strands(ABOVE, BELOW))
    rubbing = replace(robot.joints[0].coordinates[0], friction=0.125)
    summary, err = init_and_run(
        replace(robot, joints=(replace(robot.joints[0], coordinates=(rubbing,)),)),
        tmp_path,
        cardsflow,
    )
    assert_tracks(summary)
    assert "compensate for the friction of q" in err
    assert "locked" not in err
    assert tomllib.loads((tmp_path / "experiment.toml").read_text())["controller"]["observer"] > 0.0


@pytest.mark.slow
def test_motor_drives_a_coordinate_without_muscle(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = two_links(*strands(ABOVE, BELOW))
    motor = Coordinate("wrist", actuated=True, tau_min=-20.0, tau_max=20.0)
    joints = (robot.joints[0], replace(robot.joints[1], coordinates=(motor,)))
    summary, err = init_and_run(replace(robot, joints=joints), tmp_path, cardsflow)
    assert_tracks(summary)
    assert "locked" not in err
    assert list(summary["tracking"]["per_signal"]) == ["q.q", "q.wrist"]


def test_hopeless_test_runs_are_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = arm(*strands(ABOVE, BELOW))
    monkeypatch.setattr(draft_search, "_GOOD_ERROR", 1e-9)
    search = DraftSearch(robot, write_sdf(robot, tmp_path)[0], None)
    draft = next(search._drafts(first_motion(robot)))
    monkeypatch.delattr(robots, "read")  # the search reads the robot only once
    stopped, whole = search.run_test(draft, may_stop=True), search.run_test(draft)
    assert stopped is not None
    assert whole is not None
    assert stopped.is_stopped
    assert not stopped.complete
    assert whole.complete
    assert 1e-9 < stopped.error < whole.error
    best = search.find_best()[1]  # comparing failed test runs requires their end
    assert best is not None
    assert best.complete
    assert best.error <= whole.error


def test_colliding_motions_are_not_simulated_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = arm(*strands(ABOVE, BELOW))
    search = DraftSearch(robot, write_sdf(robot, tmp_path)[0], None)
    simulated = []
    run_test = DraftSearch.run_test

    def count(
        self: DraftSearch, draft: ExperimentDraft, **options: bool
    ) -> draft_search.TestRun | None:
        simulated.append(draft)
        return run_test(self, draft, **options)

    monkeypatch.setattr(DraftSearch, "run_test", count)
    monkeypatch.setattr(DraftSearch, "_collisions", lambda *_: ["a muscle meets another"])
    monkeypatch.setattr(DraftSearch, "_with_force_limits", lambda _, *run: run[:2])
    draft, test_run = search.find_best()
    assert simulated == [draft]
    assert test_run is not None
    assert test_run.is_good


def test_error_of_a_first_experiment_names_the_coordinate(tmp_path: Path) -> None:
    robot = arm(*strands(ABOVE, BELOW))
    search = DraftSearch(robot, write_sdf(robot, tmp_path)[0], None)
    draft = next(search._drafts(first_motion(robot)))
    points = tuple(replace(point, q=(4.0,)) for point in draft.motion.points)
    with pytest.raises(InputError, match=r"model\.sdf: first experiment: start\.q\.\w+: must be"):
        search.run_test(replace(draft, motion=replace(draft.motion, points=points)))


@pytest.mark.parametrize("narrow", ["crank", "coupler", "rocker"])
def test_start_pose_closes_loops_within_the_joint_limits(narrow: str) -> None:
    robot = four_bar(crank=1.0)
    pose = [c.initial for c in four_bar(crank=1.3).coordinates]
    limits = {
        c.name: (q - width, q + width)
        for c, q in zip(robot.coordinates, pose, strict=True)
        for width in [0.02 if c.name == narrow else 0.5]
    }
    joints = tuple(
        replace(j, coordinates=tuple(with_limits(c, *limits[c.name]) for c in j.coordinates))
        for j in robot.joints
    )
    robot = replace(robot, joints=joints)
    motion = first_motion(robot)
    starts = iter(motion.start)
    q = [motion.locked[n] if n in motion.locked else next(starts) for n in limits]
    assert all(low <= x <= high for x, (low, high) in zip(q, limits.values(), strict=True))
    assert close_loops(robot, q) == pytest.approx(q, abs=1e-9)


def with_limits(coordinate: Coordinate, lower: float, upper: float) -> Coordinate:
    return replace(coordinate, lower=lower, upper=upper)
