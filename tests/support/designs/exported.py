"""Export of a design of the fake to a folder, and reading of the exported robot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import fake_fusion
import numpy as np
import trimesh
from fake_fusion.maths import rotation, translation
from support.process_output import files_of

from addin_sdfusion.building.build_robot import check_design
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import Finding, Robot
from addin_sdfusion.robot.formats.read import read_robot
from addin_sdfusion.robot.model.robot import WORLD
from addin_sdfusion.snapshot import DesignSnapshot
from sim_dart.core.frames import inverse, transform

with fake_fusion.modules():
    from addin_sdfusion import addin_sdfusion
    from addin_sdfusion.fusion.design import read_design

EXPORT = "cardsflowExport"


@dataclass(frozen=True)
class Export:
    """An exported design.

    Attributes:
        folder: Robot folder.
        robot: Robot read from the folder.
        findings: Findings of the export.
    """

    folder: Path
    robot: Robot
    findings: tuple[Finding, ...]

    @property
    def codes(self) -> set[str]:
        """Return the codes of the findings."""
        return {finding.code for finding in self.findings}

    @property
    def sdf(self) -> str:
        """Return the text of model.sdf."""
        return (self.folder / "model.sdf").read_text(encoding="utf-8")

    def meshes_in_world(self, role: str = "visual") -> dict[str, Any]:
        """Return the meshes of the links in the world frame at the initial pose."""
        poses = initial_poses(self.robot)
        found = {}
        for link in self.robot.links:
            uris = [mesh.uri for mesh in link.meshes if mesh.role == role]
            parts = [trimesh.load(self.folder.parent / uri[len("model://") :]) for uri in uris]
            if parts:
                found[link.name] = trimesh.util.concatenate(parts)
                found[link.name].apply_transform(poses[link.name])
        return found

    def contents(self) -> dict[str, bytes]:
        """Return the bytes of every file."""
        return files_of(self.folder)


def snapshot_of(design: Any, **settings: Any) -> DesignSnapshot:
    """Return the snapshot of a design with changed settings."""
    snapshot = read_design(design)
    return replace(snapshot, settings=replace(snapshot.settings, **settings))


def export(design: Any, folder: Path, **settings: Any) -> Export:
    """Export a design and read the robot."""
    findings = export_robot(snapshot_of(design, **settings), folder).findings
    return Export(folder, read_robot(folder), findings)


def findings_of(design: Any) -> list[Finding]:
    """Return the findings of Check on a design."""
    return check_design(read_design(design))


def codes_of(design: Any) -> set[str]:
    """Return the codes of the findings of Check on a design."""
    return {finding.code for finding in findings_of(design)}


def initial_poses(robot: Robot) -> dict[str, np.ndarray]:
    """Return the poses of the links in the world frame at the initial coordinates."""
    poses = {WORLD: np.eye(4)}
    for joint in robot.joints:
        T = poses[joint.parent] @ transform(joint.T_parent_joint)
        for motion in joint.motions:
            value = joint.coordinates[motion.coordinate].initial
            if motion.kind == "rotation":
                T = T @ rotation(value, motion.axis)
            else:
                T = T @ translation(value * np.array(motion.axis))
        poses[joint.child] = T @ inverse(transform(joint.T_child_joint))
    return poses


@contextmanager
def running() -> Iterator[None]:
    """Run the add-in in the fake Fusion within the context."""
    with fake_fusion.modules():
        addin_sdfusion.run(None)
        try:
            yield
        finally:
            addin_sdfusion.stop(None)


def press_export(fusion: Any, folder: Path) -> Any:
    """Export with the command: choose the folder and press OK."""
    command = fusion.run_command(EXPORT)
    fusion.world.folder_answers.append(str(folder))
    command.press("browse")
    command.ok()
    return command


def failing(error: Exception) -> Any:
    """Return a function that always raises an error."""

    def fail(*_: Any, **__: Any) -> None:
        raise error

    return fail
