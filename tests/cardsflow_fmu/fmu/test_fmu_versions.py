"""FMUs of an experiment in FMI 2.0, FMI 3.0 with arrays, and FMI 3.0 with scalars."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, __version__, build
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.simulation.run import simulate

SCHEMAS = Path(fmpy.__file__).parent / "schema/fmi3"
NAMES = ("plant", "controller", "reference")
SHORT = {"run.duration": 0.2}

Version = tuple[FmiVersion, bool]
VERSIONS: tuple[Version, ...] = (("2.0", False), ("3.0", True), ("3.0", False))


@pytest.fixture(scope="module", params=["planar_2r", "roboy_left_arm"])
def example(request: pytest.FixtureRequest) -> Path:
    return EXAMPLES / str(request.param)


@pytest.fixture(scope="module", params=VERSIONS, ids=["fmi2", "fmi3_arrays", "fmi3_scalars"])
def version(request: pytest.FixtureRequest) -> Version:
    made: Version = request.param
    return made


@pytest.fixture(scope="module")
def files(
    example: Path, version: Version, tmp_path_factory: pytest.TempPathFactory
) -> Mapping[str, Path]:
    fmi, arrays = version
    folder = tmp_path_factory.mktemp("fmus")
    return build(Experiment.load(example, SHORT), folder, fmi=fmi, arrays=arrays, compute="python")


def read(file: Path, name: str) -> bytes:
    with zipfile.ZipFile(file) as archive:
        return archive.read(name)


@pytest.mark.cases(2)
@pytest.mark.slow
def test_fmpy_reports_no_problems(files: Mapping[str, Path]) -> None:
    for name in NAMES:
        assert validate_fmu(str(files[name])) == []


@pytest.mark.cases(2)
@pytest.mark.interop
def test_fmutool_reports_no_problems(files: Mapping[str, Path]) -> None:
    pytest.importorskip("fmu_manipulation_toolbox", reason="extra `interop` is not installed")
    tool = shutil.which("fmutool", path=str(Path(sys.executable).parent))
    assert tool
    for name in NAMES:
        command = [tool, "-input", str(files[name]), "-check"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        said = done.stdout + done.stderr
        assert done.returncode == 0, said
        assert "seems to be compliant" in said
        assert "No semantic error" in said
        assert "ERROR" not in said


@pytest.mark.slow
def test_terminals_are_valid(version: Version, files: Mapping[str, Path]) -> None:
    require_terminals(version)
    schema = etree.XMLSchema(etree.parse(str(SCHEMAS / "fmi3TerminalsAndIcons.xsd")))
    for name in NAMES:
        text = read(files[name], "terminalsAndIcons/terminalsAndIcons.xml")
        root = etree.fromstring(text)
        schema.assertValid(root)
        found = fmpy.read_model_description(str(files[name])).modelVariables
        members = [e.get("variableName") for e in root.iter("TerminalMemberVariable")]
        assert set(members) <= {variable.name for variable in found}
        assert len(members) == len(set(members)) > 0


def require_terminals(version: Version) -> None:
    if version[0] == "2.0":
        pytest.skip("FMI 2.0 does not define terminals")


def test_terminals_of_connected_fmus_match(version: Version, files: Mapping[str, Path]) -> None:
    """Outputs of the plant and inputs of the controller have the same member names."""
    require_terminals(version)
    terminals = {
        name: {
            (outer.get("name"), terminal.get("name")): {
                member.get("memberName") for member in terminal.findall("TerminalMemberVariable")
            }
            for outer in ET.fromstring(
                read(files[name], "terminalsAndIcons/terminalsAndIcons.xml")
            ).iterfind("Terminals/Terminal")
            for terminal in (outer, *outer.findall("Terminal"))
        }
        for name in NAMES
    }
    joints = [key for key in terminals["plant"] if key[0] == "joints"]
    assert joints
    for key in joints:
        assert terminals["plant"][key] <= terminals["controller"][key]


def test_fmus_of_fmi_2_contain_no_files_of_fmi_3(
    version: Version, files: Mapping[str, Path]
) -> None:
    """FMI Library 3.0 ends with "Mismatch of attribute 'fmiVersion'" at such a file."""
    for name in NAMES:
        with zipfile.ZipFile(files[name]) as archive:
            has_terminals = "terminalsAndIcons/terminalsAndIcons.xml" in archive.namelist()
        assert has_terminals == (version[0] == "3.0")


def test_the_fmu_contains_documentation_and_icons(
    version: Version, files: Mapping[str, Path]
) -> None:
    for name in NAMES:
        page = read(files[name], "documentation/index.html").decode()
        variables = fmpy.read_model_description(str(files[name])).modelVariables
        rows = [f"<td>{v.name}</td>" in page for v in variables if v.name != "time"]
        assert all(rows)
        assert __version__ in page
        assert "BSD 3-Clause" in read(files[name], "documentation/licenses/license.txt").decode()
        if version[0] == "2.0":
            assert read(files[name], "model.png").startswith(b"\x89PNG")
        else:
            assert read(files[name], "terminalsAndIcons/icon.png").startswith(b"\x89PNG")
            ET.fromstring(read(files[name], "terminalsAndIcons/icon.svg"))
        root = ET.fromstring(read(files[name], "modelDescription.xml"))
        assert root.get("license") == "BSD-3-Clause"
        assert root.get("version") == __version__
        slave = root.find("CoSimulation")
        assert slave is not None
        assert slave.get("needsExecutionTool") == "true"


@pytest.mark.cases(4)
@pytest.mark.slow
def test_equal_input_creates_equal_bytes(
    example: Path, version: Version, files: Mapping[str, Path], tmp_path: Path
) -> None:
    fmi, arrays = version
    again = build(
        Experiment.load(example, SHORT), tmp_path, fmi=fmi, arrays=arrays, compute="python"
    )
    for name, file in again.items():
        digests = [hashlib.sha256(f.read_bytes()).hexdigest() for f in (file, files[name])]
        assert digests[0] == digests[1], name


def test_trajectories_equal_the_trajectories_of_plain_python(
    example: Path, version: Version
) -> None:
    fmi, arrays = version
    experiment = Experiment.load(example, SHORT)
    plain = simulate(experiment, compute="python", coupling="direct")
    result = simulate(experiment, compute="python", fmi=fmi, arrays=arrays)
    assert result.names == plain.names
    assert (result.rows == plain.rows).all()


def test_fmpy_simulates_the_plant(
    example: Path, files: Mapping[str, Path], version: Version
) -> None:
    """FMPy runs without code of this package: the plant moves under constant forces."""
    experiment = Experiment.load(example, SHORT)
    plant = simulate_plant(files["plant"])
    first = experiment.start.q
    assert len(plant) == 201
    if version[1]:
        assert plant["q"].shape == (201, len(first))
        assert plant["q"][0].tolist() == list(first)
    else:
        assert plant[plant.dtype.names[1]][0] == first[0]
    flat = np.column_stack([plant[name].reshape(201, -1) for name in plant.dtype.names[1:]])
    digest = hashlib.sha256(np.ascontiguousarray(flat).tobytes()).hexdigest()
    assert DIGESTS.setdefault(example.name, digest) == digest


DIGESTS: dict[str, str] = {}
"""Trajectory of the example's plant, which is equal in all versions."""


def simulate_plant(file: Path) -> np.ndarray:
    names = [
        variable.name
        for variable in fmpy.read_model_description(str(file)).modelVariables
        if variable.causality == "output"
    ]
    result: np.ndarray = fmpy.simulate_fmu(
        str(file), stop_time=0.2, step_size=1e-3, output_interval=1e-3, output=names
    )
    return result


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "expected", "name"),
    [
        ([], "2.0", "q.joint_1"),
        (["--fmi", "3.0"], "3.0", "q"),
        (["--fmi", "3.0", "--scalars"], "3.0", "q.joint_1"),
    ],
)
def test_the_command_line_selects_the_version(
    tmp_path: Path, words: list[str], expected: str, name: str
) -> None:
    assert main(["build", str(EXAMPLES / "planar_2r"), "-o", str(tmp_path), *words]) == 0
    description = fmpy.read_model_description(str(tmp_path / "plant.fmu"))
    assert description.fmiVersion == expected
    assert name in [variable.name for variable in description.modelVariables]
    with zipfile.ZipFile(tmp_path / "system.ssp") as archive:
        archive.extract("resources/plant.fmu", tmp_path)
    inner = fmpy.read_model_description(str(tmp_path / "resources/plant.fmu"))
    assert inner.fmiVersion == "2.0"
    assert "q.joint_1" in [variable.name for variable in inner.modelVariables]
