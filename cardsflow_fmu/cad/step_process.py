"""Reader for STEP files in a separate process, since the kernel can crash on damaged files.

python -P -m cardsflow_fmu.cad.step_process REQUEST ANSWER
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.records import from_plain, to_plain
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot, write_snapshot
from cardsflow_fmu.utils.temporary import temporary_folder

from .kernel import missing
from .step_design import Tables, step_design

TIME_LIMIT = 600.0
"""Default time limit for a file, in [s]."""

_REJECTED = 2


def design_of_step(
    file: Path, tables: Tables, settings: ExportSettings, time_limit: float = TIME_LIMIT
) -> DesignSnapshot:
    """Return the snapshot of a STEP file, as `step_design`, from a separate process.

    Raises:
        InputError: As for `step_design`, or the kernel crashes or exceeds the time limit.
    """
    if find_spec("OCP") is None:
        raise missing()
    paths = (tables.joints, tables.muscles, tables.materials, tables.wraps)
    request = {
        "file": str(file),
        "tables": [None if path is None else str(path) for path in paths],
        "density": tables.density,
        "settings": to_plain(settings),
    }
    with temporary_folder() as folder:
        request_file, answer = folder / "request.json", folder / "answer.json"
        request_file.write_text(json_text(request), encoding="utf-8")
        command = [sys.executable, "-P", "-m", __name__, str(request_file), str(answer)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=time_limit
            )
        except subprocess.TimeoutExpired:
            problem = (
                f"takes longer than {time_limit:g} s; increase --time-limit, or remove small parts "
                "from the file"
            )
            raise InputError(problem, file=file) from None
        if done.returncode == _REJECTED and answer.exists():
            raise _error(json.loads(answer.read_text(encoding="utf-8")))
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines()
            problem = lines[-1] if done.returncode > 0 and lines else "the geometry kernel crashed"
            raise _unreadable(problem, file)
        return read_snapshot(answer)


def _error(plain: dict[str, str | int | None]) -> InputError:
    place = {key: plain[key] for key in ("file", "line", "key")}
    return InputError(str(plain["problem"]), **place)  # type: ignore[arg-type]


def _unreadable(problem: object, file: Path) -> InputError:
    return InputError(f"cannot be read as a STEP file: {problem}; is it damaged?", file=file)


def main(request_file: Path, answer: Path) -> int:
    """Answer a request and return the exit code."""
    request = json.loads(request_file.read_text(encoding="utf-8"))
    try:
        write_snapshot(_request_file(request), answer)
    except InputError as error:
        return _write_error(error, answer)
    except Exception as error:
        if not type(error).__module__.startswith("OCP"):  # an error of the kernel
            raise
        return _write_error(_unreadable(error, Path(request["file"])), answer)
    return 0


def _request_file(request: dict[str, Any]) -> DesignSnapshot:
    joints, muscles, materials, wraps = (None if p is None else Path(p) for p in request["tables"])
    tables = Tables(joints, muscles, materials, request["density"], wraps)
    settings = from_plain(ExportSettings, request["settings"], "settings")
    return step_design(Path(request["file"]), tables, settings)


def _write_error(error: InputError, answer: Path) -> int:
    file = None if error.file is None else str(error.file)
    plain = {"problem": error.problem, "file": file, "line": error.line, "key": error.key}
    answer.write_text(json_text(plain), encoding="utf-8")
    return _REJECTED


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
