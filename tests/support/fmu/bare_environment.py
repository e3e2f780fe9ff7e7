"""Virtual environment with an FMU importer and its dependencies, without this package."""

from __future__ import annotations

import importlib.metadata
import re
import subprocess
import venv
from pathlib import Path

import pytest

_CHECK = """
import importlib.util as u
print([name for name in ("cardsflow_fmu", "dartpy", "qpsolvers") if u.find_spec(name)])
"""


class BareEnvironment:
    """Python with only some distributions and their dependencies, linked from this Python."""

    def __init__(self, folder: Path, *distributions: str) -> None:
        venv.create(folder, with_pip=False, symlinks=True)
        self.python = folder / "bin/python"
        self._aside = folder / "aside"  # importers do not remove unpacked files
        self._aside.mkdir()
        (packages,) = folder.glob("lib/python*/site-packages")
        for name in _needed(distributions):
            _link(name, packages)
        assert self.run(["-c", _CHECK]).strip() == "[]"

    def run(self, arguments: list[str], **variables: str) -> str:
        """Run Python with a minimal environment and further variables; return its output."""
        done = subprocess.run(
            [self.python, "-I", *arguments],
            capture_output=True,
            text=True,
            timeout=1200,
            env={"PATH": "/usr/bin:/bin", "TMPDIR": str(self._aside), **variables},
            check=False,
        )
        assert done.returncode == 0, f"{done.stdout[-3000:]}{done.stderr[-6000:]}"
        return done.stdout


def _needed(distributions: tuple[str, ...]) -> set[str]:
    """Return the distributions and their dependencies on this platform, without extras."""
    found: set[str] = set()
    waiting = list(distributions)
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        try:
            distribution = importlib.metadata.distribution(name)
        except importlib.metadata.PackageNotFoundError:
            if name in distributions:
                pytest.skip(f"{name} is not installed: it is in the extra 'interop'")
            continue  # required on another platform only
        found.add(name)
        waiting += [
            re.match(r"[\w.-]+", requirement)[0]  # type: ignore[index]
            for requirement in distribution.requires or []
            if "extra ==" not in requirement
        ]
    return found


def _link(name: str, packages: Path) -> None:
    distribution = importlib.metadata.distribution(name)
    tops = {file.parts[0] for file in distribution.files or [] if file.parts[0] not in ("..", "/")}
    for top in tops - {"__pycache__"}:
        source = Path(str(distribution.locate_file(top)))
        link = packages / top
        if source.exists() and not link.exists():
            link.symlink_to(source)
