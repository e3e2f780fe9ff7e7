"""Tests of the add-in outside of Fusion: export of snapshots, installation, archive."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
from support.process_output import files_of
from support.robots.robots import planar_2r

import addin_sdfusion
from addin_sdfusion.robot import Finding, InputError, Subject
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import write_snapshot
from cardsflow_fmu import addin
from cardsflow_fmu.cli.main import main

PACKAGE = Path(addin_sdfusion.__file__).parent
DOUBT = Finding("warning", "doubt", "joint 'a' is suppressed", Subject("joint", "a"))
WRONG = Finding("error", "wrong", "joint 'a' is broken", Subject("joint", "a"))


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> list[DesignSnapshot]:
    """Replace the builder: it returns the arm of the paper for any design; return the designs."""
    seen: list[DesignSnapshot] = []

    def build_robot(snapshot: DesignSnapshot) -> SimpleNamespace:
        seen.append(snapshot)
        findings = (WRONG,) if snapshot.name == "broken" else (DOUBT,)
        robot = planar_2r()
        return SimpleNamespace(robot=robot, findings=findings, T_world_link={}, bodies_of_link={})

    monkeypatch.setattr("addin_sdfusion.exporting.export.build_robot", build_robot)
    return seen


def snapshot(folder: Path, name: str = "arm") -> str:
    settings = ExportSettings(name="arm", collision="mesh", osim=False)
    return str(write_snapshot(DesignSnapshot(name, settings), folder / f"{name}.json"))


def test_snapshot_is_exported(tmp_path, given, capsys):
    file = snapshot(tmp_path)
    assert main(["import-cad", file, "-o", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr()
    *files, test_run = printed.out.splitlines()
    assert test_run.startswith("test run passed")
    assert str(tmp_path / "out/model.sdf") in files
    assert all(Path(path).is_file() for path in files)
    assert str(DOUBT) in printed.err.splitlines()
    assert given[0].settings.collision == "mesh"


def test_settings_of_the_export_can_be_changed(tmp_path, given):
    words = ["--set", "collision=none", "--set", "osim=true", "--set", 'cut_joints=["a", "b"]']
    file = snapshot(tmp_path)
    assert main(["import-cad", file, "-o", str(tmp_path / "o"), *words]) == 0
    used = given[0].settings
    assert (used.collision, used.osim, used.cut_joints) == ("none", True, ("a", "b"))
    assert used.name == "arm"
    assert list((tmp_path / "o").glob("*.osim"))


def test_export_prints_json(tmp_path, given, capsys):
    file = snapshot(tmp_path)
    assert main(["import-cad", file, "-o", str(tmp_path / "o"), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert str(tmp_path / "o/experiment.toml") in printed["files"]
    assert DOUBT.as_dict() in printed["findings"]


def test_all_errors_of_the_design_are_listed(tmp_path, given, capsys):
    file = snapshot(tmp_path, "broken")
    assert main(["import-cad", file, "-o", str(tmp_path / "o")]) == 1
    printed = capsys.readouterr()
    assert printed.err.splitlines()[0] == str(WRONG)
    assert printed.out == ""
    assert not (tmp_path / "o").exists()
    assert main(["import-cad", file, "-o", str(tmp_path / "o"), "--json"]) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed["files"] == []
    assert printed["findings"][0] == WRONG.as_dict()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--set", "collision=soft"], "--set.collision: must be one of none, mesh, convex_hull"),
        (["--set", "colour=red"], "--set: unknown key 'colour'"),
        (["--set", "visual"], "--set: must be KEY=VALUE"),
        (["--set", "visual=1"], "--set.visual: must be of type bool"),
    ],
)
def test_invalid_export_setting_is_reported_in_one_line(tmp_path, given, capsys, words, message):
    file = snapshot(tmp_path)
    assert main(["import-cad", file, "-o", str(tmp_path / "o"), *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"cardsflow: {message}")


def test_invalid_snapshot_or_folder_is_reported_in_one_line(tmp_path, given, capsys):
    (tmp_path / "bad.json").write_text("{")
    for file, folder, message in (
        (str(tmp_path / "bad.json"), "o", "is not JSON"),
        (str(tmp_path / "none.json"), "o", "No such file"),
        (snapshot(tmp_path), "bad.json", "is a file; specify a folder"),
    ):
        command = ["import-cad", file, "-o", str(tmp_path / folder)]
        assert main(command) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert message in line


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a packaged add-in with manifest, program, icons, and caches of Python."""
    folder = tmp_path / "package/addin_sdfusion"
    for path, text in {
        "__init__.py": "",
        "addin_sdfusion.py": "def run(context): ...\n",
        "addin_sdfusion.manifest": '{"id": "the-id", "version": "1"}',
        "commands/export/icon.svg": "<svg/>",
        "robot/readers/sdf.py": "",
        "__pycache__/x.cpython-311.pyc": "no",
        "robot/__pycache__/y.pyc": "no",
        ".DS_Store": "no",
    }.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    monkeypatch.setattr(addin_sdfusion, "__file__", str(folder / "__init__.py"))
    return folder


FILES = {
    "__init__.py",
    "addin_sdfusion.py",
    "addin_sdfusion.manifest",
    "commands/export/icon.svg",
    "robot/readers/sdf.py",
}


def test_install_copies_the_add_in_and_replaces_an_earlier_copy(tmp_path, source, capsys):
    target = tmp_path / "AddIns/addin_sdfusion"
    assert main(["addin", "install", "--folder", str(tmp_path / "AddIns")]) == 0
    assert capsys.readouterr().out == f"{target}\n"
    assert set(files_of(target)) == FILES
    (target / "stale.py").write_text("")
    (source / "addin_sdfusion.py").write_text("new")
    assert addin.install(tmp_path / "AddIns") == target
    assert set(files_of(target)) == FILES
    assert (target / "addin_sdfusion.py").read_text() == "new"
    assert [path.name for path in (tmp_path / "AddIns").iterdir()] == ["addin_sdfusion"]


@pytest.mark.parametrize("manifest", [None, "", "[]", '{"id": "another"}'])
def test_folder_of_another_program_is_not_replaced(tmp_path, source, manifest):
    target = tmp_path / "AddIns/addin_sdfusion"
    target.mkdir(parents=True)
    (target / "mine.py").write_text("mine")
    if manifest is not None:
        (target / "addin_sdfusion.manifest").write_text(manifest)
    before = files_of(tmp_path / "AddIns")
    with pytest.raises(InputError, match="is not this add-in; move it"):
        addin.install(tmp_path / "AddIns")
    assert files_of(tmp_path / "AddIns") == before


def test_link_to_a_clone_is_not_replaced(tmp_path, source):
    (tmp_path / "AddIns").mkdir()
    (tmp_path / "AddIns/addin_sdfusion").symlink_to(source)
    with pytest.raises(InputError, match="is a link"):
        addin.install(tmp_path / "AddIns")
    assert set(files_of(source)) >= FILES


def test_failed_installation_keeps_the_earlier_copy(tmp_path, source, monkeypatch):
    addin.install(tmp_path / "AddIns")
    before = files_of(tmp_path / "AddIns")
    (source / "addin_sdfusion.py").write_text("new")
    plain, copy = Path.rename, addin.shutil.copyfile
    for number in range(len(FILES) + 2):
        calls = []

        def count(number=number, calls=calls):
            calls.append(1)
            if len(calls) - 1 == number:
                raise PermissionError(13, "Permission denied")

        with monkeypatch.context() as patch:
            patch.setattr(Path, "rename", lambda a, b: (count(), plain(a, b))[1])
            patch.setattr(addin.shutil, "copyfile", lambda a, b: (count(), copy(a, b))[1])
            with pytest.raises(InputError, match="Permission denied; is the add-in running"):
                addin.install(tmp_path / "AddIns")
        assert files_of(tmp_path / "AddIns") == before, number


def test_interrupted_installation_is_completed(tmp_path, source):
    target = addin.install(tmp_path / "AddIns")
    target.rename(target.with_name(".addin_sdfusion.old"))
    addin.install(tmp_path / "AddIns")
    assert [path.name for path in (tmp_path / "AddIns").iterdir()] == ["addin_sdfusion"]


@pytest.mark.parametrize(
    ("system", "below"), [("win32", "roaming"), ("darwin", "home/Library/Application Support")]
)
def test_folder_of_fusion_is_found(tmp_path, source, monkeypatch, system, below):
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setenv("APPDATA", str(tmp_path / "roaming"))
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "home")
    add_ins = tmp_path / below / "Autodesk/Autodesk Fusion 360/API/AddIns"
    with pytest.raises(InputError, match="does not exist; start Fusion once"):
        addin.install()
    add_ins.mkdir(parents=True)
    assert addin.install() == add_ins / "addin_sdfusion"


def test_folder_is_required_on_linux(source, monkeypatch, capsys):
    monkeypatch.setattr(sys, "platform", "linux")
    assert main(["addin", "install"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--folder" in line
    assert "cardsflow addin pack" in line


def test_archives_are_reproducible(tmp_path, capsys):
    packed = addin.pack_addin(tmp_path / "a/first")
    folder = tmp_path / "second"
    assert main(["addin", "pack", "-o", str(folder)]) == 0
    printed = capsys.readouterr()
    assert printed.out.split() == [str(folder / file.name) for file in packed]
    assert "the store rejects the bundle without --url and --email" in printed.err
    for file in packed:
        assert (folder / file.name).read_bytes() == file.read_bytes()


@pytest.mark.parametrize(("system", "below"), [("windows", "APPDATA"), ("mac", "~/Library")])
def test_each_system_has_an_archive(tmp_path, system, below):
    (file,) = [f for f in addin.pack_addin(tmp_path) if f.name.endswith(f"-{system}.zip")]
    with zipfile.ZipFile(file) as archive:
        assert archive.testzip() is None
        assert {name.partition("/")[0] for name in archive.namelist()} == {
            "addin_sdfusion",
            "INSTALL.txt",
        }
        manifest = json.loads(archive.read("addin_sdfusion/addin_sdfusion.manifest"))
        assert below in archive.read("INSTALL.txt").decode()
        archive.extractall(tmp_path / "AddIns")
    assert manifest["supportedOS"] == system
    target = addin.install(tmp_path / "AddIns")  # replaces the copy, because it is the same add-in
    assert (target / "addin_sdfusion.py").is_file()


@pytest.mark.slow
def test_packed_add_in_runs_without_other_packages(tmp_path):
    """Only the standard library is required."""
    with zipfile.ZipFile(addin.pack_addin(tmp_path)[0]) as archive:
        archive.extractall(tmp_path)
    path = f"import sys; sys.path.insert(0, {str(tmp_path)!r})"
    script = f"{path}; import addin_sdfusion.exporting.export as e"
    command = [sys.executable, "-I", "-S", "-c", f"{script}; print(e.__file__)"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.stderr == ""
    assert Path(done.stdout.strip()).parent == tmp_path / "addin_sdfusion" / "exporting"


def test_installed_add_in_is_complete_and_can_be_replaced(tmp_path):
    for _ in range(2):
        target = addin.install(tmp_path)
        assert (target / f"{target.name}.py").is_file()
        assert json.loads((target / f"{target.name}.manifest").read_text())["type"] == "addin"


def test_store_bundle_contains_the_add_in_and_required_files(tmp_path, capsys):
    words = ["--company", "Us & Co", "--url", "https://example.org", "--email", "a@example.org"]
    assert main(["addin", "pack", "-o", str(tmp_path), *words]) == 0
    printed = capsys.readouterr()
    *_, file = map(Path, printed.out.split())
    assert printed.err == ""
    manifest = json.loads((PACKAGE / "addin_sdfusion.manifest").read_text())
    with zipfile.ZipFile(file) as archive:
        names = set(archive.namelist())
        root = ElementTree.fromstring(archive.read("addin_sdfusion.bundle/PackageContents.xml"))
        entry = root.find("Components/ComponentEntry")
        program = f"addin_sdfusion.bundle/{entry.get('ModuleName').removeprefix('./')}"
        assert archive.read(program) == (PACKAGE / "addin_sdfusion.py").read_bytes()
    assert f"{program.removesuffix('.py')}.manifest" in names
    assert root.get("AppVersion") == manifest["version"] == entry.get("Version")
    assert root.get("UpgradeCode").strip("{}").lower() == manifest["id"]
    assert root.get("ProductCode") != root.get("UpgradeCode")
    assert root.find("CompanyDetails").get("Name") == "Us & Co"
    assert root.find("Components/RuntimeRequirements").get("OS") == "Win64|Mac"
