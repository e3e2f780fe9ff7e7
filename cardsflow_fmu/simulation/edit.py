"""Editing of a robot's muscles: evaluation of a changed document, and its muscle table on disk."""

from __future__ import annotations

import contextlib
import difflib
import hashlib
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot, check
from addin_sdfusion.robot.files import read_file, write_files
from addin_sdfusion.robot.finding_builders import listed
from addin_sdfusion.robot.formats.kinds import BY_SUFFIX, kind_of, robot_file
from addin_sdfusion.robot.formats.muscle_table.beside import MUSCLES_CSV, table_of
from addin_sdfusion.robot.formats.muscle_table.document import MuscleDocument
from addin_sdfusion.robot.formats.muscle_table.read import read_table
from addin_sdfusion.robot.formats.muscle_table.write import table_text
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.urdf.read import BY_EFFORT
from addin_sdfusion.robot.limits import XML
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from cardsflow_fmu.utils.arrays import FloatArray

from .evaluate_muscles import evaluate_muscles


class EditSession:
    """Robot whose muscles are edited. Threads can use it at the same time.

    Args:
        path: Robot file or its folder.
        report: Called with a line for each written file.

    Raises:
        RobotError: The robot is invalid.
        InputError: The files cannot be read.

    Attributes:
        robot: The robot as read.
        findings: Findings about the files.
        table: File that receives the muscles: the existing muscle table, or a new one.
    """

    def __init__(self, path: str | Path, report: Callable[[str], object] = print) -> None:
        self._path, self._report, self._lock = path, report, threading.Lock()
        self.reload()

    def reload(self) -> None:
        """Read the robot again; raises as the constructor."""
        file = robot_file(Path(self._path))
        table = table_of(file) or _new_table(file)
        content = _content(table)  # read first: a later change is then a conflict
        reading = read(file)
        robot = reading.require()
        findings = tuple(f for f in reading.findings if f.code != BY_EFFORT)
        with self._lock:
            self.file, self.findings = file, findings
            # with a muscle table, joints with an effort limit have no motors
            self.robot = robot if findings == reading.findings else _without_motors(robot)
            self.table, self._opened = table, content

    @property
    def summary(self) -> str:
        """Line that states where the muscles are saved."""
        count = len(self.robot.muscles)
        motors = [motor.name for motor in self.robot.motors]
        hint = f"; these joints also have motors: {listed(motors)}" if motors else ""
        note = "" if self.table.exists() or not count else f" and then replace those of {self.file}"
        return f"{count} muscles; changes are saved to {self.table}{note}{hint}"

    def data(self, token: str | None) -> dict[str, Any]:
        """Return the data of a page: name, document, laws, files, token and digest.

        Args:
            token: Token of requests to a server; None for a page without a server.
        """
        content = self._opened
        text = "" if content is None else content.decode("utf-8-sig", "replace")
        return {
            "name": self.robot.name,
            "document": MuscleDocument.of(self.robot).to_plain(),
            "laws": muscle_laws(),
            "files": {self.table.name: text},
            "token": token,
            "digest": _digest(content),
        }

    def evaluate(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Return lengths, paths, moment arms, torque ranges and findings of a document at a pose.

        Args:
            request: `document`, and `pose` with the positions of the coordinates.
        """
        with self._lock:
            try:
                pose = self._pose(request.get("pose"))
                document = MuscleDocument.from_plain(request.get("document"))
                return evaluate_muscles(document.apply_to(self.robot), pose) | {"error": None}
            except CardsflowError as error:
                return {"findings": [], "error": _one_line(error)}

    def save(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Return the difference to the file on disk, or write the file.

        Args:
            request: `document`; `digest` of the file that the page has read; and `write`.

        Returns:
            `path`, `diff`, `digest` of the file, and `conflict` or `error` if nothing was written.
        """
        with self._lock:
            answer = {"path": str(self.table), "diff": "", "conflict": None, "error": None}
            try:
                text = self._text(MuscleDocument.from_plain(request.get("document")))
                before = _content(self.table)
                answer |= {"diff": self._diff(before, text), "digest": _digest(before)}
                if request.get("digest") != _digest(before):
                    problem = "changed on disk; reload the page to edit the new file"
                    answer["conflict"] = f"{self.table}: {problem} (unsaved changes are lost)"
                elif request.get("write") is True:
                    write_files(self.table.parent, {self.table.name: text})
                    answer["digest"] = _digest(text.encode())
                    self._report(f"wrote {self.table}")
            except CardsflowError as error:
                answer["error"] = _one_line(error)
            return answer

    def _pose(self, values: Any) -> FloatArray:
        n = len(self.robot.coordinates)
        if not isinstance(values, list) or len(values) != n:
            raise InputError(f"must be a list of {n} numbers", key="pose")
        try:
            pose = np.array(values, dtype=float)
        except (TypeError, ValueError):
            pose = np.full(n, np.nan)
        if not np.isfinite(pose).all():
            raise InputError("must contain finite numbers", key="pose")
        return pose

    def _text(self, document: MuscleDocument) -> str:
        """Return the text of the table.

        Raises:
            InputError: A muscle has an error, so that the robot could not be read again.
        """
        changed = document.apply_to(self.robot)
        errors = [finding for finding in check(changed) if finding.is_error]
        if errors:
            raise InputError(f"{errors[0].message}; correct it before saving")
        text = table_text(document)
        links = [link.name for link in self.robot.links]
        again = read_table(text.encode(), links, self.table)
        if again.document.apply_to(self.robot) != changed:
            problem = f"cannot hold these names or values: {[str(f) for f in again.findings[:1]]}"
            raise InputError(problem, file=self.table)
        return text

    def _diff(self, before: bytes | None, text: str) -> str:
        old = b"" if before is None else before
        lines = old.decode("utf-8-sig", "replace").splitlines()
        name = self.table.name
        return "\n".join(difflib.unified_diff(lines, text.splitlines(), name, name, lineterm=""))


def _content(table: Path) -> bytes | None:
    """Return the content of a file, or None if it does not exist."""
    return read_file(table, XML) if table.exists() else None


def muscle_laws() -> dict[str, list[dict[str, Any]]]:
    """Return the parameters of all muscle laws, by the name of the law."""
    return {
        name: [
            {
                "name": p.name,
                "unit": p.unit,
                "default": p.default,
                "lower": p.low,
                "upper": p.high,
                "description": p.meaning,
            }
            for p in law.parameters
        ]
        for name, law in MUSCLE_LAWS.items()
    }


def _without_motors(robot: Robot) -> Robot:
    joints = (j.map_coordinates(lambda c: replace(c, actuated=False)) for j in robot.joints)
    return replace(robot, joints=tuple(joints))


def _new_table(file: Path) -> Path:
    """Return the name of a new table, which no other robot file in the folder uses."""
    with contextlib.suppress(OSError):
        for other in sorted(file.parent.iterdir()):
            if other.name != file.name and _is_robot(other):
                return file.with_name(f"{file.stem}.{MUSCLES_CSV}")
    return file.with_name(MUSCLES_CSV)


def _is_robot(file: Path) -> bool:
    if file.suffix not in (*BY_SUFFIX, ".xml") or not file.is_file():
        return False
    try:
        return kind_of(file) is not None
    except InputError:
        return False


def _digest(content: bytes | None) -> str:
    return "" if content is None else hashlib.sha256(content).hexdigest()


def _one_line(error: CardsflowError) -> str:
    return " ".join(str(error).split())
