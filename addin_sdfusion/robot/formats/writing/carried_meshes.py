"""Copying of the meshes of a robot to the folder where the robot is written."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ...errors import InputError
from ...files import write_files
from ...finding import Finding, Subject
from ...finding_builders import warning
from ...mesh_files import MODEL_URIS, is_file, mesh_bytes, mesh_file, packed_name
from ...model.robot import Robot
from ...transforms.part_map import PartMap

Opens = Callable[[str, bytes], bool]


@dataclass
class CarriedMeshes:
    """Meshes that are copied together with a robot.

    Attributes:
        folder: Folder of the robot file. Meshes outside it are not copied.
        files: Source file by its path relative to the robot folder, which does not change.
        names: Relative path by the URI in the robot.
        not_copied: Reason why a file is not copied, by the URI in the robot.
    """

    folder: Path
    files: dict[str, Path] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    not_copied: dict[str, str] = field(default_factory=dict)

    @staticmethod
    def of(robot: Robot, folder: Path) -> CarriedMeshes:
        """Return the valid mesh files of a robot that exist inside its folder."""
        carried = CarriedMeshes(folder)
        for uri in dict.fromkeys(mesh.uri for link in robot.links for mesh in link.meshes):
            file = mesh_file(uri, folder, [folder])
            if not is_file(file):
                continue
            try:
                mesh_bytes(file, [folder])
            except InputError as error:
                carried.not_copied[uri] = error.problem
                continue
            name = file.resolve().relative_to(folder.resolve()).as_posix()
            carried.names[uri], carried.files[name] = name, file
        return carried

    def readable_by(self, opens: Opens) -> dict[str, str]:
        """Return the names of the files that a program can open, for the `meshes` of writers."""
        return {
            name: name
            for name, file in self.files.items()
            if opens(file.suffix.lower(), mesh_bytes(file, [self.folder]))
        }

    def apply_to(self, robot: Robot, *, keeps_models: bool) -> Robot:
        """Return the robot with the relative paths as mesh URIs.

        Args:
            keeps_models: Whether to keep URIs of models (`model://`) that mean the same file.
        """

        def place(uri: str) -> str:
            is_kept = keeps_models and self._has_model_uri(uri)
            return uri if is_kept else self.names.get(uri, uri)

        return PartMap(mesh_uri=place).apply_to(robot)

    def losses(self, robot: Robot) -> Iterator[Finding]:
        """Report the meshes that are not copied."""
        for uri, reason in self.not_copied.items():
            problem = f"mesh {uri!r} is not copied: {reason}"
            yield warning(Subject("robot", robot.name), "mesh-not-carried", problem)

    def write(self, folder: Path) -> list[Path]:
        """Write the files; raise InputError if the folder is not writable or contains links."""
        written = []
        for name, file in self.files.items():
            place = folder / name
            for parent in place.parents[: len(Path(name).parts) - 1]:
                if parent.is_symlink():  # an untrusted folder could redirect the output elsewhere
                    raise InputError("is a link; remove it, or choose another folder", file=parent)
            data = mesh_bytes(file, [self.folder])
            written += write_files(place.parent, {place.name: data})
        return written

    def _has_model_uri(self, uri: str) -> bool:
        return uri.startswith(MODEL_URIS) and self.names.get(uri) == packed_name(uri)
