"""STEP files in a process of their own: the kernel crashes on some that are damaged.

python -m cardsflow_fmu.cad.step_process REQUEST ANSWER
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from addin_sdfusion.records import from_plain, to_plain
from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot, write_snapshot
from cardsflow_fmu.utils.temporary import temporary_folder

from .kernel import missing
from .step_design import Tables, step_design

TIME_LIMIT = 600.0
"""How long a file may take, in [s]."""

_REFUSED = 2


def design_of_step(
    file: Path, tables: Tables, settings: ExportSettings, time_limit: float = TIME_LIMIT
) -> DesignSnapshot:
    """As `step_design`, whatever the file makes of the kernel, within `time_limit`, in [s]."""
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
        asked, answer = folder / "request.json", folder / "answer.json"
        asked.write_text(json_text(request), encoding="utf-8")
        command = [sys.executable, "-m", __name__, str(asked), str(answer)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=time_limit
            )
        except subprocess.TimeoutExpired:
            what = (
                f"takes longer than {time_limit:g} s; allow more (--time-limit), or leave small "
                "parts out of the file"
            )
            raise InputError(what, file=file) from None
        if done.returncode == _REFUSED and answer.exists():
            raise _error(json.loads(answer.read_text(encoding="utf-8")))
        if done.returncode != 0:
            said = done.stderr.strip().splitlines()
            what = said[-1] if done.returncode > 0 and said else "the kernel crashes on it"
            raise _unreadable(what, file)
        return read_snapshot(answer)


def _error(plain: dict[str, str | int | None]) -> InputError:
    place = {key: plain[key] for key in ("file", "line", "key")}
    return InputError(str(plain["what"]), **place)  # type: ignore[arg-type]


def _unreadable(what: object, file: Path) -> InputError:
    return InputError(f"cannot be read as a STEP file: {what}; is it damaged?", file=file)


def main(asked: Path, answer: Path) -> int:
    """Answer a request; returns the exit code."""
    request = json.loads(asked.read_text(encoding="utf-8"))
    try:
        write_snapshot(_asked(request), answer)
    except InputError as error:
        return _refuse(error, answer)
    except Exception as error:
        if not type(error).__module__.startswith("OCP"):  # the kernel's own, of no common class
            raise
        return _refuse(_unreadable(error, Path(request["file"])), answer)
    return 0


def _asked(request: dict[str, Any]) -> DesignSnapshot:
    joints, muscles, materials, wraps = (None if p is None else Path(p) for p in request["tables"])
    tables = Tables(joints, muscles, materials, request["density"], wraps)
    settings = from_plain(ExportSettings, request["settings"], "settings")
    return step_design(Path(request["file"]), tables, settings)


def _refuse(error: InputError, answer: Path) -> int:
    file = None if error.file is None else str(error.file)
    plain = {"what": error.what, "file": file, "line": error.line, "key": error.key}
    answer.write_text(json_text(plain), encoding="utf-8")
    return _REFUSED


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
