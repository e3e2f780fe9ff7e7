"""Export of a design snapshot to a robot folder that can be simulated.

    model.sdf, model.config, cardsflow.xml   the robot with its muscles
    meshes/visual, meshes/collision          STL, in metres, in the frames of the links
    experiment.toml                          experiment for `cardsflow run`; only `cardsflow
                                             import-cad` writes it, after a test run
    caspr/, <name>.osim                      for CASPR and OpenSim
    urdf/, mjcf/                             the same robot with its meshes for ROS and MuJoCo
    findings.txt, findings.json              warnings, and data that a format does not support

The files do not depend on the date or the machine: the same design results in identical files.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from ..building.build_robot import BuiltRobot, build_robot
from ..building.robot_findings import check_measured
from ..progress import Progress, no_progress
from ..report import merge_similar, report_json, report_text, sort_findings
from ..robot.errors import RobotError
from ..robot.files import write_files
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import warning
from ..robot.formats.caspr.capabilities import caspr_losses
from ..robot.formats.caspr.write import write_caspr
from ..robot.formats.convert import FORMATS, Format, convert_to, format_of
from ..robot.formats.opensim.write import write_osim
from ..robot.formats.sdf.capabilities import sdf_losses
from ..robot.formats.sdf.write import write_sdf
from ..robot.formats.writing.carried_meshes import CarriedMeshes
from ..robot.model.pose import IDENTITY
from ..robot.model.robot import Link, Robot
from ..robot.model.rotations import inverse
from ..robot.transforms.part_map import PartMap
from ..settings import ExportSettings
from ..snapshot import DesignSnapshot
from .changes import changes, contents
from .gentle_motion import gentle_motion
from .link_meshes import link_meshes
from .manifest import read_contents
from .robot_folder import EXPERIMENT, Replacement, folder_replacement
from .safe_names import safe_name, safe_names
from .simulation_checks import can_simulate, simulation_findings

CASPR = "caspr"
"""Name of the folder of CASPR's files."""

PROGRAMS = {"caspr": "CASPR", "osim": "OpenSim", "urdf": "URDF", "mjcf": "MuJoCo"}
"""Name of the program or format, by the setting of the format."""

Experiment = Callable[[Path], tuple[str, Iterable[Finding]]]
"""Function that returns the text of experiment.toml for the robot files in a folder, and findings.

The text is empty if there is no experiment."""


class Exported(NamedTuple):
    """Result of an export.

    Attributes:
        files: The exported files, in order.
        findings: Warnings, data that a format does not support, and files of the user that were
            kept.
        changed: Differences from the previous export; None for the first export.
        losses: The findings on data that a format does not support, by the setting of the format,
            such as `caspr`. A format without losses is not included.
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]
    changed: tuple[str, ...] | None = None
    losses: Mapping[str, tuple[Finding, ...]] = {}


def requested_findings(
    findings: Iterable[Finding],
    losses: Mapping[str, tuple[Finding, ...]],
    requested: Collection[str],
    folder: str | Path,
) -> tuple[list[Finding], str]:
    """Return the findings without losses of formats that were not requested, and a note on them.

    Args:
        findings: All findings of an export.
        losses: Losses of each format, as in `Exported`.
        requested: Formats that the user requested; the others are written by default.

    Returns:
        The findings, and one line on the losses; empty if there are none.
    """
    other = {name: lost for name, lost in losses.items() if name not in requested}
    hidden = {finding for lost in other.values() for finding in lost}
    if not other:
        return list(findings), ""
    names = " and ".join(PROGRAMS[name] for name in other)
    note = (
        f"the files for {names} do not contain everything: see the "
        f"{sum(map(len, other.values()))} warnings in {Path(folder) / 'findings.txt'}"
    )
    return [finding for finding in findings if finding not in hidden], note


def export_robot(
    snapshot: DesignSnapshot,
    folder: str | Path,
    *,
    progress: Progress | None = None,
    experiment: Experiment | None = None,
) -> Exported:
    """Write the robot folder of a design and replace the files of an earlier export.

    If an error is raised, the folder is unchanged.

    Args:
        snapshot: The design, with the settings of the export.
        folder: Target folder; created if it does not exist. Gazebo uses its name as model name.
        progress: Called with the progress; may raise `Cancelled`.
        experiment: Provides experiment.toml; None to write no experiment.

    Raises:
        RobotError: The design has errors; the exception contains all findings.
        InputError: The folder cannot be written.
        Cancelled: The user cancelled the export.
    """
    built = build_robot(snapshot)
    return export_built(built, snapshot.settings, folder, progress=progress, experiment=experiment)


def export_built(
    built: BuiltRobot,
    settings: ExportSettings,
    folder: str | Path,
    *,
    progress: Progress | None = None,
    experiment: Experiment | None = None,
) -> Exported:
    """Write the robot folder like `export_robot`, for a robot that is already built."""
    after = contents(built.robot) if built.robot is not None else {}
    with folder_replacement(folder) as replacement:
        export = _Export(built, settings, replacement, progress or no_progress, experiment)
        findings = export.write()
        before = read_contents(replacement.folder)
        files, kept_findings = replacement.commit(after)
    changed = None if before is None else tuple(changes(before, after))
    return Exported(files, sort_findings([*findings, *kept_findings]), changed, export.losses)


class _Export:
    """Writer for one export.

    Attributes:
        losses: Data that a format does not support, by the setting of the format.
    """

    def __init__(
        self,
        built: BuiltRobot,
        settings: ExportSettings,
        replacement: Replacement,
        progress: Progress,
        experiment: Experiment | None,
    ) -> None:
        self._built = built
        self._settings = settings
        self._folder = replacement.new
        self._model = replacement.folder.name
        self._progress = progress
        self._experiment = experiment
        self.losses: dict[str, tuple[Finding, ...]] = {}
        self._findings: list[Finding] = list(built.findings)

    def write(self) -> tuple[Finding, ...]:
        """Write all files and return all findings."""
        robot = self._with_meshes(self._require_valid())
        links = len(robot.links)
        self._progress(links, links + 3, "robot files")
        self._findings += merge_similar(sdf_losses(robot))
        write_sdf(robot, self._folder)
        self._write_experiment(robot)
        self._progress(links + 1, links + 3, "files of other programs")
        stem = safe_name(robot.name)
        if self._settings.caspr:
            self._write_caspr(robot, stem)
        if self._settings.osim:
            self._write_osim(robot, stem)
        for name, is_chosen in (("urdf", self._settings.urdf), ("mjcf", self._settings.mjcf)):
            if is_chosen:
                self._write_with_meshes(name, robot)
        findings = sort_findings(self._findings)
        reports = {"findings.txt": report_text(findings), "findings.json": report_json(findings)}
        write_files(self._folder, reports)
        self._progress(links + 2, links + 3, "moving files to the folder")
        return findings

    def _require_valid(self) -> Robot:
        """Return the robot, or raise its errors."""
        robot = self._built.robot
        if robot is not None:
            self._findings += check_measured(robot)
            self._findings += [finding for finding in sdf_losses(robot) if finding.is_error]
        findings = sort_findings(self._findings)
        if robot is None or any(finding.is_error for finding in findings):
            raise RobotError(findings)
        return robot

    def _with_meshes(self, robot: Robot) -> Robot:
        """Write the meshes and return the robot with references to them."""
        stems = safe_names(link.name for link in robot.links)
        links = []
        for i, link in enumerate(robot.links):
            self._progress(i, len(robot.links) + 3, f"meshes of {link.name}")
            links.append(self._with_mesh(link, stems[link.name]))
        return replace(robot, links=tuple(links))

    def _with_mesh(self, link: Link, stem: str) -> Link:
        bodies = self._built.bodies_of_link.get(link.name, ())
        T_link_world = inverse(self._built.T_world_link[link.name]) if bodies else IDENTITY
        exported = link_meshes(link.name, stem, bodies, T_link_world, self._settings)
        self._findings += exported.findings
        for path, content in exported.files.items():
            file = self._folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        root = f"model://{self._model}"  # Gazebo finds a model by the name of its folder
        meshes = (replace(mesh, uri=f"{root}/{mesh.uri}") for mesh in exported.meshes)
        return replace(link, meshes=tuple(meshes), shapes=exported.shapes)

    def _write_experiment(self, robot: Robot) -> None:
        self._findings += simulation_findings(robot)
        if self._experiment is not None and can_simulate(robot):
            text, findings = self._experiment(self._folder)
            self._findings += findings
            if text:
                write_files(self._folder, {EXPERIMENT: text})

    def _write_caspr(self, robot: Robot, name: str) -> None:
        if not robot.coordinates:
            problem = "no files for CASPR are written: the robot has no movable joints"
            self._findings.append(warning(Subject("robot", robot.name), "caspr-no-joints", problem))
            return
        trajectories = [gentle_motion(robot)]
        losses = partial(caspr_losses, trajectories=trajectories)
        write = partial(write_caspr, name=name, trajectories=trajectories)
        caspr = FORMATS["caspr"]._replace(losses=losses, write=write, is_named=False)
        self._write_as("caspr", caspr, robot, CASPR)

    def _write_osim(self, robot: Robot, name: str) -> None:
        meshes = {mesh.uri: self._below(mesh.uri) for link in robot.links for mesh in link.meshes}
        write = partial(write_osim, name=name, meshes=meshes)
        osim = FORMATS["osim"]._replace(write=write, is_named=False)
        self._write_as("osim", osim, robot, "")

    def _write_with_meshes(self, name: str, robot: Robot) -> None:
        """Write a robot with its meshes into a separate, self-contained folder."""
        robot = PartMap(mesh_uri=self._below).apply_to(robot)
        carried = CarriedMeshes.of(robot, self._folder)
        self._write_as(name, format_of(name, meshes=carried), robot, name)

    def _below(self, uri: str) -> str:
        """Return the path of a mesh relative to the robot folder."""
        return uri.removeprefix(f"model://{self._model}/")

    def _write_as(self, name: str, format_: Format, robot: Robot, folder: str) -> None:
        """Write the files for another program, or report why they cannot be written."""
        try:
            written = convert_to(format_, robot, self._folder / folder)
        except RobotError as error:
            self._findings += _as_warnings(PROGRAMS[name], error)
        else:
            losses = merge_similar(written.findings)
            self._findings += losses
            if losses:
                self.losses[name] = tuple(losses)


def _as_warnings(program: str, error: RobotError) -> list[Finding]:
    """Return warnings instead of errors, since the files for other programs can be written."""
    errors = [finding for finding in error.findings if finding.is_error]
    return [
        Finding("warning", f.code, f"no files for {program} are written: {f.message}", f.subject)
        for f in merge_similar(errors)
    ]
