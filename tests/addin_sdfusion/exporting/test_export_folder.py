"""Tests of the replacement of files: an export replaces either all of its files or none."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from support.designs.built_stubs import built
from support.process_output import files_of
from support.robots.robots import planar_2r

from addin_sdfusion.exporting.export import export_built
from addin_sdfusion.exporting.manifest import MANIFEST
from addin_sdfusion.exporting.robot_folder import PART, folder_replacement
from addin_sdfusion.robot import Finding, InputError, Robot, read_robot
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.settings import ExportSettings

ALL = ExportSettings()


def other_arm() -> Robot:
    """Return the arm under another name, with a renamed and heavier link."""
    robot = planar_2r()
    first = robot.links[0]
    heavy = replace(first, inertia=replace(first.inertia, mass=7.0), end=None)
    joints = (robot.joints[0], robot.joints[1])
    links = (heavy, replace(robot.links[1], name="hand", end=None))
    joints = (joints[0], replace(joints[1], child="hand"))
    return replace(
        robot,
        name="other",
        links=links,
        joints=joints,
        cable_sets=tuple(
            replace(
                group,
                muscles=tuple(
                    replace(
                        muscle,
                        via_points=tuple(
                            replace(p, link="hand") if p.link == "link_2" else p
                            for p in muscle.via_points
                        ),
                    )
                    for muscle in group.muscles
                ),
            )
            for group in robot.cable_sets
        ),
        task_sets=(),
        task_set="",
    )


def experiment(folder: Path) -> tuple[str, list[Finding]]:
    """Return an experiment that depends on the initial pose of the exported robot."""
    lines = [f"{c.name} = {c.initial!r}\n" for c in read_robot(folder).coordinates]
    return "kp = 2000.0\n" + "".join(lines), []


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    export_built(built(bodies=2), ALL, tmp_path / "arm", experiment=experiment)
    return tmp_path / "arm"


def test_earlier_files_are_replaced_and_stale_ones_removed(arm):
    exported = export_built(built(other_arm()), ALL, arm)
    assert set(files_of(arm)) == {f.relative_to(arm).as_posix() for f in exported.files} | {
        MANIFEST
    }
    assert not (arm / "meshes/visual/link_2.stl").exists()
    assert read_robot(arm).links[0].inertia.mass == 7.0


def test_empty_folders_are_removed(arm):
    export_built(built(), ExportSettings(caspr=False, visual=False, collision="none"), arm)
    assert [path.name for path in arm.iterdir() if path.is_dir()] == []


def test_other_files_are_unchanged(arm):
    (arm / "notes.txt").write_text("mine")
    (arm / "meshes/visual/mine.stl").write_text("mine")
    (arm / "results").mkdir()
    (arm / "results/results.csv").write_text("1,2")
    chosen = ExportSettings(visual=False, collision="none", caspr=False)
    export_built(built(other_arm()), chosen, arm)
    assert (arm / "notes.txt").read_text() == "mine"
    assert (arm / "meshes/visual/mine.stl").read_text() == "mine"
    assert (arm / "results/results.csv").read_text() == "1,2"


def test_unchanged_files_are_not_written(arm):
    before = {path: path.stat().st_mtime_ns for path in arm.rglob("*") if path.is_file()}
    export_built(built(bodies=2), ALL, arm)
    after = {path: path.stat().st_mtime_ns for path in arm.rglob("*") if path.is_file()}
    assert {path.name for path in after if after[path] != before[path]} <= {MANIFEST}


def test_unknown_files_are_not_overwritten(tmp_path):
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm/model.sdf").write_text("<sdf/>")
    before = files_of(tmp_path)
    with pytest.raises(InputError, match=r"contains files that no export wrote: model\.sdf; move"):
        export_built(built(), ALL, tmp_path / "arm")
    assert files_of(tmp_path) == before


def test_equal_files_are_accepted_without_a_manifest(arm):
    before = files_of(arm)
    (arm / MANIFEST).unlink()
    export_built(built(bodies=2), ALL, arm, experiment=experiment)
    assert files_of(arm) == before


def test_a_changed_file_is_kept_as_backup(arm):
    original = (arm / "model.sdf").read_bytes()
    for number, name in enumerate(("model.sdf.bak", "model.sdf.bak2")):
        (arm / "model.sdf").write_text(f"changed {number}")
        exported = export_built(built(bodies=2), ALL, arm)
        assert (arm / "model.sdf").read_bytes() == original
        assert (arm / name).read_text() == f"changed {number}"
        (finding,) = [f for f in exported.findings if f.code == "changed-file-kept"]
        assert name in finding.message
    assert (arm / "model.sdf.bak").read_text() == "changed 0"


def test_converted_line_endings_are_not_a_change(arm):
    for name in ("model.sdf", "experiment.toml"):
        content = (arm / name).read_bytes()
        (arm / name).write_bytes(content.replace(b"\n", b"\r\n"))
    export_built(built(other_arm()), ALL, arm, experiment=experiment)
    assert not list(arm.rglob("*.bak"))
    assert not (arm / "experiment.new.toml").exists()
    assert b"\r\n" not in (arm / "experiment.toml").read_bytes()


def test_a_changed_experiment_is_kept(arm):
    original = (arm / "experiment.toml").read_text()
    mine = original.replace("kp = 2000.0", "kp = 900.0")
    (arm / "experiment.toml").write_text(mine)
    for _ in range(2):  # no finding if the new experiment is unchanged
        exported = export_built(built(bodies=2), ALL, arm, experiment=experiment)
        assert (arm / "experiment.toml").read_text() == mine
        assert not (arm / "experiment.new.toml").exists()
        assert "experiment-kept" not in [f.code for f in exported.findings]
    moved = planar_2r()
    joints = tuple(
        replace(joint, coordinates=(replace(joint.coordinates[0], initial=0.5),))
        for joint in moved.joints
    )
    for _ in range(2):
        exported = export_built(
            built(replace(moved, joints=joints)), ALL, arm, experiment=experiment
        )
        assert (arm / "experiment.toml").read_text() == mine
        assert "joint_1 = 0.5\n" in (arm / "experiment.new.toml").read_text()
        assert "experiment-kept" in [f.code for f in exported.findings]
    (arm / "experiment.toml").unlink()
    export_built(built(replace(moved, joints=joints)), ALL, arm, experiment=experiment)
    assert "joint_1 = 0.5\n" in (arm / "experiment.toml").read_text()
    assert not (arm / "experiment.new.toml").exists()


def test_an_export_without_experiments_keeps_those_of_the_user(tmp_path):
    arm = tmp_path / "arm"
    export_built(built(), ALL, arm)
    assert not (arm / "experiment.toml").exists()
    (arm / "experiment.toml").write_text("mine")
    export_built(built(), ALL, arm)
    assert (arm / "experiment.toml").read_text() == "mine"


def test_an_obsolete_experiment_is_removed_unless_changed(arm):
    bare = replace(planar_2r(), cable_sets=(), cable_set="")
    export_built(built(bare), ALL, arm, experiment=experiment)
    assert not (arm / "experiment.toml").exists()
    export_built(built(), ALL, arm, experiment=experiment)
    (arm / "experiment.toml").write_text("mine")
    export_built(built(bare), ALL, arm, experiment=experiment)
    assert (arm / "experiment.toml").read_text() == "mine"


class KilledError(Exception):
    """The process is killed without cleanup."""


@contextlib.contextmanager
def failing(
    number: int, error: Callable[[], BaseException], *, dead: bool = False
) -> Iterator[list[str]]:
    """Make the `number`th write or move fail; with `dead`, all later ones too."""
    calls: list[str] = []

    def counted(name: str, plain: Callable[..., object]) -> Callable[..., object]:
        def call(*arguments: object, **more: object) -> object:
            calls.append(name)
            if len(calls) - 1 == number or (dead and len(calls) - 1 > number):
                raise error()
            return plain(*arguments, **more)

        return call

    with pytest.MonkeyPatch.context() as patch:
        names = ["write_bytes", "write_text", "replace", "mkdir"]
        names += ["unlink", "rmdir"] if dead else []
        for name in names:
            patch.setattr(Path, name, counted(name, getattr(Path, name)))
        if dead:
            patch.setattr("shutil.rmtree", counted("rmtree", lambda *_, **__: None))
        yield calls


def full() -> OSError:
    return OSError(28, "No space left on device")


def count_of_steps(tmp_path: Path) -> int:
    folder = tmp_path / "count"
    export_built(built(bodies=2), ALL, folder)
    (folder / "model.sdf").write_text("changed")
    with failing(-1, full) as calls:
        export_built(built(other_arm()), ALL, folder)
    return len(calls)


@pytest.mark.slow
def test_a_full_disk_at_any_write_or_move_keeps_the_old_export(tmp_path, arm):
    (arm / "model.sdf").write_text("changed")
    (arm / "notes.txt").write_text("mine")
    before, other = files_of(arm), built(other_arm())
    steps = count_of_steps(tmp_path)
    assert steps > 50
    for number in range(steps):
        with failing(number, full), pytest.raises(MachineError) as caught:
            export_built(other, ALL, arm)
        assert caught.value.file == arm
        assert "No space left" in str(caught.value)
        assert files_of(arm) == before, number
    export_built(other, ALL, arm)
    assert read_robot(arm).links[0].inertia.mass == 7.0


@pytest.mark.slow
def test_an_interrupted_swap_is_undone(tmp_path, arm):
    before, other = files_of(arm), built(other_arm())
    for number in range(0, count_of_steps(tmp_path), 5):
        with failing(number, KeyboardInterrupt), contextlib.suppress(KeyboardInterrupt):
            export_built(other, ALL, arm)
            continue
        assert files_of(arm) == before, number


@pytest.mark.slow
def test_after_a_crash_the_next_export_restores_the_old_one(tmp_path, arm):
    """The process is killed during the moves, without cleanup."""
    before, other = files_of(arm), built(other_arm())
    steps = count_of_steps(tmp_path)
    for number in range(steps - 45, steps, 2):
        with failing(number, KilledError, dead=True), contextlib.suppress(KilledError, OSError):
            export_built(other, ALL, arm)
        with folder_replacement(arm):  # recovers without new files
            pass
        after = files_of(arm)
        if after != before:  # the moves were complete except for the cleanup
            assert b"<mass>7.0</mass>" in after["model.sdf"]
            export_built(built(bodies=2), ALL, arm)
        assert files_of(arm) == before, number
        assert not (arm / PART).exists()


def test_a_first_export_that_fails_leaves_no_folder(tmp_path):
    with failing(5, full), pytest.raises(MachineError):
        export_built(built(), ALL, tmp_path / "a/b/arm")
    assert list(tmp_path.iterdir()) == []


def test_invalid_folders_are_rejected(tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    for name, message in (
        ("file", "is a file; specify a folder"),
        ("file/below", "cannot be written"),
        ("link", "is a link; specify its target"),
        ("con", "some operating systems reject"),
        ("a:b", "some operating systems reject"),
        ("dot.", "some operating systems reject"),
    ):
        with pytest.raises(InputError, match=message):
            export_built(built(), ALL, tmp_path / name)
    with pytest.raises(InputError, match="is a drive; specify"):
        export_built(built(), ALL, "/")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "link", "real"]


def test_a_read_only_folder_is_rejected(tmp_path, monkeypatch):
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(InputError, match="cannot be written: Permission denied"):
        export_built(built(), ALL, tmp_path / "arm")


def test_links_in_the_folder_are_not_followed(tmp_path, arm):
    before = files_of(arm)
    for path in ("meshes", "model.sdf"):
        (arm / path).rename(tmp_path / f"moved {path}")
        (arm / path).symlink_to(tmp_path / f"moved {path}")
        for chosen in (ALL, ExportSettings(visual=False, collision="none")):
            with pytest.raises(InputError, match="is a link; remove it"):
                export_built(built(other_arm()), chosen, arm)
        (arm / path).unlink()
        (tmp_path / f"moved {path}").rename(arm / path)
    assert files_of(arm) == before


def test_a_folder_instead_of_a_file_is_rejected(arm):
    (arm / "model.config").unlink()
    (arm / "model.config").mkdir()
    with pytest.raises(InputError, match="is a folder, but a file is required"):
        export_built(built(other_arm()), ALL, arm)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"format": 2, "files": {}}',
        '{"format": 1, "files": []}',
        '{"format": 1, "files": {"a": 1}}',
        '{"format": 1, "files": {"../victim": "0"}}',
        '{"format": 1, "files": {"/etc/victim": "0"}}',
        '{"format": 1, "files": {"a/../../victim": "0"}}',
        '{"format": 1, "files": {"C:victim": "0"}}',
        '{"format": 1, "files": {"a\\\\b": "0"}}',
        "[" * 100_000,
    ],
)
def test_a_damaged_or_hostile_manifest_is_rejected(tmp_path, arm, text):
    (tmp_path / "victim").write_text("mine")
    (arm / MANIFEST).write_text(text)
    before = files_of(tmp_path)
    with pytest.raises(InputError, match="is damaged"):
        export_built(built(other_arm()), ALL, arm)
    assert files_of(tmp_path) == before


@pytest.mark.parametrize("text", ["", "{}", '[["../victim", "a"]]', '[["a"]]', "[[1, 2]]"])
def test_a_damaged_or_hostile_journal_is_rejected(tmp_path, arm, text):
    (tmp_path / "victim").write_text("mine")
    (arm / PART).mkdir()
    (arm / PART / "moves.json").write_text(text)
    before = files_of(tmp_path)
    with pytest.raises(InputError, match="is damaged"):
        export_built(built(other_arm()), ALL, arm)
    assert files_of(tmp_path) == before


def test_a_link_renamed_only_in_case_is_exported(arm):
    """On a case-insensitive file system the old `Hand` is removed before `hand` is written."""
    robot = other_arm()
    export_built(built(robot), ALL, arm)
    names = files_of(arm)
    manifest = json.loads(names[MANIFEST])
    old = "meshes/visual/hand.stl"
    manifest["files"]["meshes/visual/HAND.stl"] = manifest["files"].pop(old)
    (arm / MANIFEST).write_text(json.dumps(manifest))
    os.link(arm / old, arm / "meshes/visual/HAND.stl")  # both names refer to one file
    export_built(built(robot), ALL, arm)
    assert files_of(arm) == names
