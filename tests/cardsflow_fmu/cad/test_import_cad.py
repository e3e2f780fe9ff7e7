"""Import of designs without the geometry kernel: snapshots, tables and failing programs."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.designs.design_strategies import Draughtsman
from support.documents import ROOT, blocks
from support.process_output import files_of

from addin_sdfusion.robot import InputError, RobotError, read_robot
from addin_sdfusion.snapshot_file import snapshot_text
from cardsflow_fmu import Experiment
from cardsflow_fmu.cad import import_cad
from cardsflow_fmu.cad.tables import read_joints, read_materials
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.cli.setup.init import schema
from cardsflow_fmu.simulation.run import simulate
from sim_dart import DartDynamics

EXAMPLE = ROOT / "examples/from_cad/two_link_arm.json"


def test_snapshot_is_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["import-cad", str(EXAMPLE), "-o", "a/arm", "--set", "collision=none"]) == 0
    assert not any(path.startswith("meshes/collision") for path in files_of(Path("a/arm")))
    assert main(["import-cad", str(EXAMPLE)]) == 0
    assert (tmp_path / "two_link_arm/model.sdf").is_file()


def changed_example(folder: Path, f_max: float = 100.0, muscles: int = 4) -> Path:
    """Write the example with other force limits, in [N], and with its first muscles only."""
    content = json.loads(EXAMPLE.read_text())
    design = content["design"]
    design["muscles"] = [{**m, "f_max": f_max} for m in design["muscles"][:muscles]]
    kept = {None, *(m["name"] for m in design["muscles"])}
    design["points"] = [p for p in design["points"] if p["use"].get("muscle") in kept]
    (folder / "arm.json").write_text(json.dumps(content))
    return folder / "arm.json"


@pytest.mark.parametrize("changes", [{}, {"f_max": 11.0}, {"muscles": 3}], ids=str)
def test_the_experiment_of_an_imported_design_tracks(
    tmp_path: Path, changes: dict[str, Any]
) -> None:
    """A motion of 0.1 rad is too large for weak muscles; a joint without muscles is locked."""
    made = import_cad(changed_example(tmp_path, **changes), tmp_path / "robot")
    assert made.test_run is not None
    assert made.test_run.is_good
    result = simulate(Experiment.load(tmp_path / "robot"), coupling="direct")
    assert result.summary["infeasible_ticks"] == 0
    errors = result.summary["tracking"]["per_signal"].values()
    assert max(row["max"] for row in errors) == pytest.approx(made.test_run.error)
    assert ("joint_2 is locked" in " ".join(made.notes)) == ("muscles" in changes)


def test_a_design_that_cannot_move_is_imported_without_an_experiment(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One muscle cannot hold the arm."""
    file = changed_example(tmp_path, muscles=1)
    assert main(["import-cad", str(file), "-o", str(tmp_path / "robot")]) == 0
    line = next(x for x in capsys.readouterr().err.splitlines() if "[no-experiment]" in x)
    assert line.startswith(
        "warning: file 'experiment.toml': it is not written: robot 'planar_2r': "
    )
    assert read_robot(tmp_path / "robot").muscles
    assert not (tmp_path / "robot/experiment.toml").exists()


def test_only_losses_of_requested_formats_are_printed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "robot"
    in_osim, in_caspr = "[limits-are-ranges]", "[caspr-meshes]"
    assert main(["import-cad", str(EXAMPLE), "-o", str(folder)]) == 0
    printed = capsys.readouterr()
    (line,) = printed.err.splitlines()  # the design has no findings
    assert "the files for CASPR and OpenSim do not contain everything: see the" in line
    assert "test run passed" in printed.out
    report = (folder / "findings.txt").read_text()
    assert in_osim in report
    assert in_caspr in report
    assert main(["import-cad", str(EXAMPLE), "-o", str(folder), "--set", "osim=true"]) == 0
    printed = capsys.readouterr()
    assert in_osim in printed.err
    assert in_caspr not in printed.err
    assert "the files for CASPR do not contain everything" in printed.err


def one_line(capsys: pytest.CaptureFixture[str], *words: Any) -> str:
    """Return the error message of a rejected import."""
    assert main(["import-cad", *map(str, words)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    return line.removeprefix("cardsflow: ")


def test_a_missing_extra_is_named_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for module in [name for name in sys.modules if name.partition(".")[0] in ("OCP", "build123d")]:
        monkeypatch.delitem(sys.modules, module)
    for module in ("OCP", "build123d"):
        monkeypatch.setitem(sys.modules, module, None)
    Path("arm.step").write_text("ISO-10303-21;\n")
    assert "extra cad" in one_line(capsys, "arm.step")
    Path("arm.py").write_text("import json\nfrom build123d import Box\n")
    assert "extra cad" in one_line(capsys, "arm.py")
    assert not Path("arm").exists()


PROGRAMS = {
    "x = 1\n": "arm.py: must define exactly one cardsflow_fmu.cad.Design; found none",
    "x = 1\ny = x / 0\n": "arm.py:2: ZeroDivisionError: division by zero",
    "def f():\n    raise SystemExit('no')\n\nf()\n": "arm.py:2: SystemExit: no",
    "x = (\n": "arm.py:1: is not Python: '(' was never closed",
    "from cardsflow_fmu.cad import Design\nd = Design([], colour=1)\n": "arm.py:2: settings: unkn",
    "from cardsflow_fmu.cad import Design\nd = Design([])\nd.muscle('m', 7)\n": "arm.py:3: muscle",
    "from cardsflow_fmu.cad import Design\nd = Design([])\nd.muscle('m')\nd.muscle('m')\n":
        "arm.py:4: muscle 'm' already exists",
    "from cardsflow_fmu.cad import Design\na, b = Design([]), Design([])\n": "found 2: a, b",
}  # fmt: skip


@pytest.mark.parametrize("text", PROGRAMS)
def test_programs_without_a_design_are_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.py").write_text(text)
    assert PROGRAMS[text] in one_line(capsys, "arm.py")


def test_invalid_options_are_rejected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = one_line(capsys, EXAMPLE, "-o", tmp_path / "arm", "--density", "7850")
    assert said.startswith(f"{EXAMPLE}: ")
    assert "STEP" in said
    assert "--density" in one_line(capsys, "arm.step", "--density", "nan")
    assert "not a design in a known format" in one_line(capsys, "arm.sldasm")


HEAD = "name,type,parent,child,x [mm],y [mm],z [mm],axis x,axis y,axis z,lower,upper,value\n"
GOOD = "elbow,revolute,upper,lower,10,20,30,0,1,0,-90 deg,1.5,10 deg\n"


def test_joints_are_read_with_their_units(tmp_path: Path) -> None:
    file = tmp_path / "joints.csv"
    text = HEAD + GOOD + "\nslide,slider,lower,hand,,,,0,0,2,-5 mm,0.1,\n"
    for content in (text, text.replace(",", ";"), text.replace(",", "\t"), "\ufeff" + text):
        file.write_text(content, encoding="utf-8")
        elbow, slide = read_joints(file)
        assert elbow.origin == pytest.approx((0.01, 0.02, 0.03))
        (turn,), (shift,) = elbow.motions, slide.motions
        assert (turn.lower, turn.upper) == pytest.approx((-np.pi / 2, 1.5))
        assert turn.value == pytest.approx(np.pi / 18)
        assert (shift.lower, shift.upper, shift.value) == (-0.005, 0.1, 0.0)
        assert slide.name.line == 4
        assert slide.origin is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "joints.csv: is empty"),
        ("name,type,parent\n", "joints.csv:1: has no column 'child'"),
        (HEAD.replace("value", "colour"), "joints.csv:1: no column 'colour'"),
        (HEAD.replace("upper", "lower"), "joints.csv:1: has two columns 'lower'"),
        (HEAD + GOOD + GOOD.replace("revolute", "weld"), "joints.csv:3: type: no type of joint"),
        (HEAD + GOOD.replace("10,20", "ten,20"), "joints.csv:2: x: must be a number, not 'ten'"),
        (HEAD + GOOD.replace("10,20", "nan,20"), "joints.csv:2: x: must be a number"),
        (HEAD + GOOD.replace("1.5", "1.5 mm"), "joints.csv:2: upper: no unit 'mm'"),
        (
            (HEAD + GOOD).replace("\n", ",velocity\n", 1).replace("10 deg", "0,1 m/s"),
            "joints.csv:2: velocity: no unit 'm/s'",
        ),
        (HEAD + GOOD.replace("0,1,0", "0,0,0"), "joints.csv:2: axis x: an axis must not be"),
        (HEAD + GOOD.replace("0,1,0", ",,"), "joints.csv:2: name: a revolute joint needs an axis"),
        (HEAD + GOOD.replace("10,20,30", ",,"), "joints.csv:2: name: a revolute joint needs an o"),
        (
            HEAD + GOOD.replace("10,20,30", "10,20,"),
            "joints.csv:2: x: also requires a value in column 'z'",
        ),
        (HEAD + GOOD.replace("upper,lower", ",lower"), "joints.csv:2: 'parent' must not be empty"),
        (
            HEAD + GOOD.replace("\n", ",9\n"),
            "joints.csv:2: has 14 cells, but the first line has 13",
        ),
        (HEAD + '"' + "a" * 200_000, "joints.csv:2: cannot be read"),
    ],
)
def test_invalid_tables_are_rejected_with_their_line(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "joints.csv"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        read_joints(file)
    assert str(caught.value).startswith(f"{tmp_path}/{said}")
    assert "\n" not in str(caught.value)


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_rejected(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    file = tmp_path_factory.getbasetemp() / "table.csv"
    for head in (b"", HEAD.encode() + GOOD.encode(), b"part,density,mass\n"):
        file.write_bytes(head + data)
        for read in (read_joints, read_materials):
            with contextlib.suppress(InputError):  # any other error fails the test
                read(file)


def test_materials_are_read_or_rejected_with_their_line(tmp_path: Path) -> None:
    file = tmp_path / "materials.csv"
    file.write_text("part,density [g/cm3],mass [g],material\narm,7.85,,Steel\nhand,,250,\n")
    arm, hand = read_materials(file)
    assert (arm.density, arm.mass, arm.material) == (pytest.approx(7850.0), None, "Steel")
    assert (hand.density, hand.mass) == (None, pytest.approx(0.25))
    for line, said in (
        ("arm,1,1,", "either"),
        ("arm,,,", "either"),
        ("arm,-1,,", "must be positive"),
    ):
        file.write_text(f"part,density,mass,material\n{line}\n")
        with pytest.raises(InputError, match=said) as caught:
            read_materials(file)
        assert caught.value.line == 2


def test_the_schema_accepts_written_snapshots(capsys: pytest.CaptureFixture[str]) -> None:
    """It accepts random designs and the example, and rejects invalid values."""
    assert main(["schema", "snapshot"]) == 0
    schema = json.loads(capsys.readouterr().out)
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    for seed in range(10):
        validator.validate(json.loads(snapshot_text(Draughtsman(seed, 4).draw().snapshot)))
    example = json.loads(EXAMPLE.read_text())
    validator.validate(example)
    for where, value in (
        (("format",), 1),
        (("design", "colour"), "red"),
        (("design", "name"), 7),
        (("design", "muscles", 0, "color"), "red"),
        (("design", "muscles", 0, "model"), "magic"),
        (("design", "joints", 0, "origin_one"), [1, 2]),
        (("design", "points", 0, "use", "role"), "eye"),
        (("design", "settings"), {"quality": "superb"}),
    ):
        damaged = json.loads(EXAMPLE.read_text())
        at = damaged
        for step in where[:-1]:
            at = at[step]
        at[where[-1]] = value
        assert not validator.is_valid(damaged), where


@pytest.mark.slow
def test_the_example_in_the_docs_creates_a_robot(tmp_path: Path) -> None:
    """Muscles pull the pendulum in both directions; its hinge has the limits in the file."""
    (block,) = (b for b in blocks(ROOT / "docs/reference/snapshot.md") if b.language == "json")
    (tmp_path / "pendulum.json").write_text(block.text)
    made = import_cad(tmp_path / "pendulum.json", tmp_path / "robot")
    assert not any(finding.is_error for finding in made.findings)
    robot = read_robot(tmp_path / "robot")
    (hinge,) = robot.coordinates
    assert (hinge.name, hinge.lower, hinge.upper, hinge.damping) == ("hinge", -1.0, 1.0, 0.02)
    arm = DartDynamics(robot)
    q = np.zeros(1)
    left, right = arm.muscle_jacobian(q)[:, 0]
    assert left == pytest.approx(-right)
    assert abs(left) == pytest.approx(0.4 * 0.4 / math.hypot(0.4, 0.4))
    assert arm.mass_matrix(q)[0, 0] == pytest.approx(0.1)
    jsonschema.validate(json.loads(block.text), schema("snapshot"))


@pytest.mark.slow
def test_damaged_snapshots_create_a_robot_or_one_line(tmp_path: Path) -> None:
    """One to five values of a valid file are replaced, exchanged or removed."""
    count = max(30, int(os.environ.get("CARDSFLOW_MUTATIONS", "60")))  # reaches all outcomes
    rng = np.random.default_rng(21)
    text = EXAMPLE.read_text()
    outcomes: Counter[str] = Counter()
    for _ in range(count):
        content = json.loads(text)
        for _ in range(rng.integers(1, 6)):
            damage(content, rng)
        (tmp_path / "damaged.json").write_text(json.dumps(content))
        outcomes[outcome(tmp_path / "damaged.json", tmp_path / "robot")] += 1
    assert set(outcomes) == {"robot", "findings", "rejected"}, outcomes


def outcome(file: Path, folder: Path) -> str:
    try:
        import_cad(file, folder, {"visual": False})
        read_robot(folder)
    except RobotError as error:
        wrong = any(finding.is_error for finding in error.findings)
        return "findings" if wrong else "no reason"
    except InputError as error:
        return "rejected" if len(str(error).splitlines()) == 1 else str(error)
    return "robot"


ODD: tuple[Any, ...] = (
    None, "", "world", "base:1", "no such", -1, 0, 1e308, -1e-320, 2**70, "inf", True, [], {}, [[]],
    "\n", "\u0000", "x" * 5000, [0, 0, 0], [1e200, 0, 0], {"type": "d", "zlib": ""},
)  # fmt: skip


def damage(content: Any, rng: np.random.Generator) -> None:
    """Change one random value in plain data."""
    holders = list(_holders(content)) or [{"": content}]
    holder = holders[rng.integers(len(holders))]
    keys = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
    key, other = (keys[rng.integers(len(keys))] for _ in range(2))
    how = rng.integers(4)
    if how == 0:
        del holder[key]
    elif how == 1:
        holder[key], holder[other] = holder[other], holder[key]
    elif how == 2 and isinstance(holder, list):
        holder.append(holder[key])
    else:
        holder[key] = ODD[rng.integers(len(ODD))]


def _holders(content: Any) -> Iterator[Any]:
    if isinstance(content, dict | list) and content:
        yield content
        for inner in content.values() if isinstance(content, dict) else content:
            yield from _holders(inner)
