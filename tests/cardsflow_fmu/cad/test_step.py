"""Import of STEP files: tree, poses, masses, triangles and tables."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.command_server import command_server
from support.designs.design_strategies import forward
from support.designs.step_hands import JOINTS, MUSCLES, TURNS, write_hands

from addin_sdfusion.robot import InputError, RobotError, read_robot
from addin_sdfusion.robot.model.transform import IDENTITY
from addin_sdfusion.robot.records import to_plain
from addin_sdfusion.settings import ExportSettings
from cardsflow_fmu.cad import Tables, import_cad, step_process
from cardsflow_fmu.cad.kernel import kernel, mass_of, mesh_of
from cardsflow_fmu.cad.step_design import step_design
from cardsflow_fmu.cad.step_process import design_of_step
from cardsflow_fmu.cli.main import main

pytestmark = [pytest.mark.slow, pytest.mark.extra("cad")]

READER = """
import sys
from pathlib import Path
from cardsflow_fmu.cad.step_process import main
sys.exit(main(*map(Path, sys.argv[1:])))
"""
LOADED = ["cardsflow_fmu.cad.step_process"]
LOADED += [f"OCP.{name}" for name in ("STEPCAFControl", "XCAFDoc", "BRepMesh", "BRepGProp")]


def matrix(*places: str) -> Any:
    """Return T_root_part of nested places, lengths in [m]."""
    T = np.eye(4)
    for place in places:
        t, turn = TURNS[place]
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = Rotation.from_rotvec(turn).as_matrix(), 0.001 * np.array(t)
        T = T @ step
    return T


@pytest.fixture(scope="module")
def step(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("step") / "robot.step"
    write_hands(file)
    return file


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[str]]:
    """Return the command of a reader that forks a process with the kernel, without arguments."""
    folder = tmp_path_factory.mktemp("reader")
    (folder / "read.py").write_text(READER)
    with command_server(folder, os.environ, LOADED) as client:
        yield [*client, str(folder / "read.py")]


@pytest.fixture
def in_forks(reader: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Read files in forks of one process, since the kernel takes a second to start."""

    def run(command: list[str], **options: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*reader, *command[-2:]], check=False, **options)

    forks = SimpleNamespace(run=run, TimeoutExpired=subprocess.TimeoutExpired)
    monkeypatch.setattr(step_process, "subprocess", forks)


@pytest.fixture
def tables(tmp_path: Path) -> Tables:
    found = Tables(tmp_path / "joints.csv", tmp_path / "muscles.csv", None, 7850.0)
    assert found.joints is not None
    assert found.muscles is not None
    found.joints.write_text(JOINTS, encoding="utf-8")
    found.muscles.write_text(MUSCLES, encoding="utf-8")
    return found


PLACES = {
    "händ:1": ("hand",),
    "händ:1+palm:1": ("hand",),
    "händ:1+finger:1": ("hand", "index"),
    "händ:1+finger:2": ("hand", "thumb"),
    "händ:2": ("twin",),
    "händ:2+palm:1": ("twin",),
    "händ:2+finger:1": ("twin", "index"),
    "händ:2+finger:2": ("twin", "thumb"),
    "palm:1": ("foot",),
}


def test_all_instances_have_their_pose_and_mass(step: Path, tables: Tables) -> None:
    """Masses, centres and inertia match closed forms; triangles enclose the volume."""
    design = step_design(step, tables, ExportSettings())
    assert design.name == "robot"
    assert {o.path for o in design.occurrences} == set(PLACES)
    assert {o.component for o in design.occurrences} == {"händ", "palm", "finger"}
    assert len(design.bodies) == 7
    for body in design.bodies:
        T = matrix(*PLACES[body.occurrence])
        is_palm = "palm" in body.occurrence.rpartition("+")[2]
        assert body.color == (None if is_palm else "#ff8000")
        volume = 0.01 * 0.02 * 0.03 if is_palm else math.pi * 0.005**2 * 0.04
        m = 7850.0 * volume
        com = np.array([0.005, 0.01, 0.015] if is_palm else [0.0, 0.0, 0.02])
        if is_palm:
            J = m / 12.0 * np.diag([0.02**2 + 0.03**2, 0.01**2 + 0.03**2, 0.01**2 + 0.02**2])
        else:
            across = m * (3 * 0.005**2 + 0.04**2) / 12.0
            J = np.diag([across, across, m * 0.005**2 / 2.0])
        assert body.mass is not None
        assert body.mesh is not None
        c = T[:3, :3] @ com + T[:3, 3]
        about_root = T[:3, :3] @ J @ T[:3, :3].T + m * (c @ c * np.eye(3) - np.outer(c, c))
        expected = [*np.diag(about_root), *(about_root[i, j] for i, j in ((0, 1), (1, 2), (0, 2)))]
        assert body.mass.mass == pytest.approx(m, rel=1e-12)
        np.testing.assert_allclose(body.mass.com, c, rtol=0, atol=1e-12)
        np.testing.assert_allclose(body.mass.moments, expected, rtol=0, atol=1e-9 * max(expected))
        np.testing.assert_allclose(body.mass.principal, np.sort(np.diag(J)), rtol=1e-9)
        nodes = np.array(body.mesh.nodes).reshape(-1, 3)
        a, b, d = (nodes[np.array(body.mesh.triangles)[k::3]] for k in range(3))
        enclosed = float(np.einsum("ij,ij->", a, np.cross(b, d)) / 6.0)
        assert enclosed == pytest.approx(volume, rel=1e-9 if is_palm else 0.03)


@pytest.mark.parametrize("kind", ["Cylinder", "Sphere", "Torus", "Cone", "Box"])
def test_masses_match_closed_forms(kind: str) -> None:
    """The shapes are in [mm] with density 1000 kg/m³; the relative tolerance is 1e-9."""
    a, b, h = 30.0, 10.0, 70.0
    shape, volume, J_zz = {
        "Cylinder": ((a, h), math.pi * a * a * h, a * a / 2.0),
        "Sphere": ((a,), 4.0 / 3.0 * math.pi * a**3, 0.4 * a * a),
        "Torus": ((a, b), 2.0 * math.pi**2 * a * b * b, a * a + 0.75 * b * b),
        "Cone": ((a, 0.0, h), math.pi * a * a * h / 3.0, 0.3 * a * a),
        "Box": ((a, b, h), a * b * h, (a * a + b * b) / 12.0),
    }[kind]
    solid = getattr(kernel("BRepPrimAPI"), f"BRepPrimAPI_Make{kind}")(*shape).Shape()
    mass = mass_of(solid, IDENTITY, 1000.0, 0.001)
    assert mass is not None
    assert mass.mass == pytest.approx(1e-6 * volume, rel=1e-9)
    own = mass.moments[2] - mass.mass * (mass.com[0] ** 2 + mass.com[1] ** 2)
    assert own == pytest.approx(1e-6 * volume * 1e-6 * J_zz, rel=1e-9)
    counts = [
        len(mesh.triangles)
        for quality in ("low", "normal", "high")
        if (mesh := mesh_of(solid, IDENTITY, quality, 0.001)) is not None  # type: ignore[arg-type]
    ]
    assert kind == "Box" or counts == sorted(set(counts))


@pytest.mark.usefixtures("in_forks")
def test_tables_complete_a_robot(step: Path, tables: Tables, tmp_path: Path) -> None:
    words = ["--joints", tables.joints, "--muscles", tables.muscles, "--density", 7850]
    arguments = ["import-cad", step, "-o", tmp_path / "hand", *words]
    assert main(list(map(str, arguments))) == 0
    robot = read_robot(tmp_path / "hand")
    held = "händ_händ_palm"  # a part without a joint is fixed to its parent
    assert {joint.name for joint in robot.joints} == {"base", "wrist", "curl", "slip", held}
    limits = {c.name: (c.lower, c.upper, c.damping) for c in robot.coordinates}
    assert limits["wrist"] == pytest.approx((-math.pi / 2, math.pi / 2, 0.1))
    assert limits["slip"] == pytest.approx((-0.005, 0.005, 0.0))
    speeds = {c.name: c.max_velocity for c in robot.coordinates}
    assert speeds == pytest.approx({"wrist": math.pi, "curl": math.pi, "slip": 0.02})
    (muscle,) = robot.muscles
    assert (muscle.f_min, muscle.f_max) == (5.0, 50.0)
    poses = forward(robot, {c.name: 0.0 for c in robot.coordinates})
    at = [poses[p.link] @ [*p.position, 1.0] for p in muscle.via_points]
    np.testing.assert_allclose([p[:3] for p in at], [(0, 0, 0), (0.11, 0, 0.04)], atol=1e-12)


def world(*places: str, at: tuple[float, ...] = (0.0, 0.0, 0.02)) -> np.ndarray:
    """Return a point of a part in the world, in [m]; default: the middle of a finger."""
    return np.asarray((matrix(*places) @ [*at, 1.0])[:3])


def wraps_of(folder: Path, *rows: str) -> Path:
    file = folder / "wraps.csv"
    first = "name,part,x [mm],y [mm],z [mm],muscle,after,side,turns,inside"
    file.write_text("\n".join([first, *rows]), encoding="utf-8")
    return file


@pytest.mark.usefixtures("in_forks")
def test_muscles_wrap_over_faces_near_a_point(step: Path, tables: Tables, tmp_path: Path) -> None:
    """One finger is found by a point on its axis, the other by a point on its face."""
    axis, face = (
        ",".join(f"{1000 * v:.17g}" for v in place)
        for place in (world("hand", "index"), world("twin", "thumb", at=(0.0, 0.005, 0.01)))
    )
    assert tables.muscles is not None
    again = MUSCLES.splitlines()[1].replace("via,m", "via,n")
    tables.muscles.write_text(f"{MUSCLES}{again}\n{again.replace(',0,palm', ',1,finger')}\n")
    file = wraps_of(
        tmp_path,
        f"index,händ:1+finger:1,{axis},m,0,-,1,",
        "index,händ:1+finger:1,,,,n,0,,,yes",
        f"thumb,händ:2,{face},m,0,,,",
    )
    words = ["--joints", tables.joints, "--muscles", tables.muscles, "--wraps", file]
    arguments = ["import-cad", step, "-o", tmp_path / "hand", *words, "--density", 7850]
    assert main(list(map(str, arguments))) == 0
    robot = read_robot(tmp_path / "hand")
    first, second = robot.wrap_surfaces
    assert (first.name, second.name) == ("index", "thumb")
    poses = forward(robot, {c.name: 0.0 for c in robot.coordinates})
    for surface, places in ((first, ("hand", "index")), (second, ("twin", "thumb"))):
        assert (surface.radius, surface.length) == pytest.approx((0.005, 0.04), rel=1e-12)
        centre = poses[surface.link] @ [*surface.pose.position, 1.0]
        np.testing.assert_allclose(centre[:3], world(*places), atol=1e-12)
        turned = Rotation.from_euler("xyz", surface.pose.rpy).as_matrix()[:, 2]
        along = (poses[surface.link][:3, :3] @ turned) @ matrix(*places)[:3, 2]
        assert abs(along) == pytest.approx(1.0, abs=1e-12)
    uses = {
        m.name: [(w.surface, w.side, w.turns, w.inside) for w in m.wraps] for m in robot.muscles
    }
    assert uses["m"] == [("index", -1, 1, False), ("thumb", 0, 0, False)]
    assert uses["n"] == [("index", 0, 0, True)]


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("w,foot,0,0,0,m,0,,,", "wraps.csv:2: part: no part 'foot'"),
        ("w,palm:1,0,0,0,m,0,,,", "wraps.csv:2: part: part 'palm:1' has neither cylinder nor"),
        ("w,händ:1,0,0,0,m,0,,,", "mm away; use a point on the face or on its axis"),
        ("w,händ:1,,,,m,0,,,", "wraps.csv:2: name: a point near the face is missing"),
        ("w,händ:1,1,,,m,0,,,", "wraps.csv:2: x: also requires a value in column 'y'"),
        ("w,händ:1,0,0,0,o,0,,,", "wraps.csv:2: muscle: no muscle 'o'"),
        ("w,händ:1,0,0,0,m,-1,,,", "wraps.csv:2: after: must be 0, 1, 2, ..., not '-1'"),
        ("w,händ:1,0,0,0,m,0,left,,", "wraps.csv:2: side: no value 'left'"),
        (
            "w,händ:1,0,0,0,m,0,+,,yes",
            "wraps.csv:2: inside: a muscle inside its surface cannot have",
        ),
    ],
)
def test_an_invalid_wrap_is_rejected_with_its_cell(
    step: Path, tables: Tables, tmp_path: Path, row: str, said: str
) -> None:
    with pytest.raises(InputError) as refused:
        step_design(step, replace(tables, wraps=wraps_of(tmp_path, row)), ExportSettings())
    assert said in str(refused.value)


def test_a_file_that_exceeds_the_time_limit_is_rejected_in_one_line(
    step: Path, tables: Tables, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["-q", "--joints", str(tables.joints), "--time-limit", "0.01"]
    assert main(["import-cad", str(step), "-o", str(tmp_path / "no"), *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "takes longer than 0.01 s; increase --time-limit" in line
    assert not (tmp_path / "no").exists()
    assert main(["import-cad", str(step), *words[:-1], "-1"]) == 2
    assert "--time-limit: must be positive and finite" in capsys.readouterr().err


def test_materials_table_sets_masses_of_parts(step: Path, tables: Tables, tmp_path: Path) -> None:
    file = tmp_path / "materials.csv"
    file.write_text("part,density,mass,material\nhänd,,2,\nhänd:2+finger:2,1000,,Nylon\n")
    design = step_design(step, Tables(tables.joints, None, file), ExportSettings())
    of = {body.occurrence: body for body in design.bodies}
    assert of["palm:1"].mass is None
    first = [b.mass.mass for path, b in of.items() if path.startswith("händ:1") and b.mass]
    assert math.fsum(first) == pytest.approx(2.0, rel=1e-12)
    nylon = of["händ:2+finger:2"]
    assert nylon.mass is not None
    assert nylon.mass.mass == pytest.approx(math.pi * 1000 * 0.005**2 * 0.04, rel=1e-12)
    assert nylon.material == "Nylon"
    assert of["händ:2+palm:1"].mass is None


@pytest.mark.usefixtures("in_forks")
def test_invalid_input_is_rejected_in_one_line(
    step: Path, tables: Tables, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def said(*words: Any) -> str:
        command = ["import-cad", str(step), "-q", "-o", str(tmp_path / "no")]  # without progress
        assert main([*command, *map(str, words)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        return line.removeprefix("cardsflow: ")

    assert "its parts are 'händ:1', 'händ:1+palm:1'" in said()
    joints = tmp_path / "bad.csv"
    for old, new, line in (
        ("palm:1,händ,", "palm:1,foot,", "bad.csv:3: child: no part 'foot'"),
        ("palm:1,händ,", "palm:1,index,", "bad.csv:3: child: part 'index' is not unique"),
        ("palm:1,händ,", "händ,händ:1,", "bad.csv:3: child: is the same part as the parent"),
        ("world,palm:1", "palm:1,world", "bad.csv:2: child: the world does not move"),
    ):
        joints.write_text(JOINTS.replace(old, new), encoding="utf-8")
        with pytest.raises(InputError) as refused:
            step_design(step, Tables(joints), ExportSettings())
        assert str(refused.value).startswith(f"{tmp_path}/{line}")
    assert said("--joints", joints).startswith(f"{tmp_path}/{line}")
    cut = tmp_path / "cut.step"
    for damaged in (step.read_bytes()[: len(step.read_bytes()) // 2], b"\x00\xff" * 100):
        cut.write_bytes(damaged)
        assert main(["import-cad", str(cut), "-q", "--joints", str(tables.joints)]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert tables.muscles is not None
    tables.muscles.write_text(MUSCLES.replace("finger", "thumb"))
    with pytest.raises(RobotError) as caught:
        import_cad(step, tmp_path / "no", {}, tables)
    wrong = [f for f in caught.value.findings if f.is_error]
    assert {(f.file, f.line) for f in wrong} >= {(tables.muscles, 3), (tables.muscles, 4)}
    assert not (tmp_path / "no").exists()


def test_an_infinite_mass_is_rejected(step: Path, tables: Tables) -> None:
    with pytest.raises(InputError, match="results in a mass of"):
        step_design(step, replace(tables, density=1e308), ExportSettings())


def test_an_infinite_inertia_is_rejected() -> None:
    solid = kernel("BRepPrimAPI").BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()
    far = IDENTITY._replace(p=(1e200, 0.0, -1e200))
    with pytest.raises(InputError, match="inertia of a body is not finite"):
        mass_of(solid, far, 1000.0, 0.001)


def test_settings_select_the_links(step: Path, tables: Tables) -> None:
    settings = ExportSettings("other", components=("händ:1", "palm:1"))
    assert step_design(step, tables, settings).settings == settings


def test_a_file_that_crashes_the_kernel_is_rejected_in_one_line(step: Path, tmp_path: Path) -> None:
    """Random references between entities: some of them crash the kernel process."""
    rng, text = np.random.default_rng(8), step.read_bytes()
    places = [match.start() + 1 for match in re.finditer(rb"#[0-9]{2,}[,)]", text)]
    said, number = Counter[bool](), int(os.environ.get("CARDSFLOW_MUTATIONS", "0")) // 75
    for k in range(max(4, number)):
        data = bytearray(text)
        for at in rng.choice(places, 12):
            data[at : at + 2] = f"{rng.integers(10, 99)}".encode()
        (tmp_path / f"{k}.step").write_bytes(data)
        with pytest.raises(InputError) as refused:  # at least the table of joints is missing
            design_of_step(tmp_path / f"{k}.step", Tables(), ExportSettings())
        assert len(str(refused.value).splitlines()) == 1
        said["the geometry kernel crashed" in refused.value.problem] += 1
        if said[True] and k + 1 >= number:
            break
    assert said[True], said


def test_python_files_beside_a_design_are_not_executed(
    step: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "json.py").write_text("raise SystemExit('executed')")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as refused:  # the table of joints is missing
        design_of_step(step, Tables(), ExportSettings())
    assert "executed" not in refused.value.problem


def test_errors_of_the_kernel_are_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(step_process, "step_design", lambda *_: kernel("gp").gp_Dir(0.0, 0.0, 0.0))
    asked, answer = tmp_path / "request.json", tmp_path / "answer.json"
    settings = to_plain(ExportSettings())
    request = {"file": "a.step", "tables": [None] * 4, "density": None, "settings": settings}
    asked.write_text(json.dumps(request))
    assert step_process.main(asked, answer) == 2
    what = json.loads(answer.read_text())["problem"]
    assert re.fullmatch("cannot be read as a STEP file: gp_Dir.* zero norm; is it damaged.", what)
