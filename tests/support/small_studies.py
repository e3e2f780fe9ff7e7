"""Short studies of the two-link arm."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from cardsflow_fmu.studies import Study, StudyResult, run_study

ROOT = Path(__file__).parents[2]
PLANAR = ROOT / "examples" / "planar_2r"

SHORT = """
[settings]
controller.period = 0.01
run.step = 0.01
run.duration = 0.2
"""

KP = """
[[vary]]
path = "controller.kp"
grid = { from = 1000.0, to = 2000.0, count = 6 }
"""


def write_study(folder: Path, text: str = KP, top: str = "", short: str = SHORT) -> Path:
    """Write a study.toml from top-level keys, settings of short runs, and further tables."""
    file = folder / "study.toml"
    file.write_text(f'experiment = "{PLANAR}"\n{top}\n{short}\n{text}')
    return file


def small_study(folder: Path, text: str = KP, top: str = "", short: str = SHORT) -> Study:
    """Write a study like `write_study`, and read it."""
    return Study.load(write_study(folder, text, top, short))


def run_here(study: Study, output: Path | None = None, **options: Any) -> StudyResult:
    """Run a study in a thread of this process."""
    with ThreadPoolExecutor(1) as executor:
        return run_study(study, executor, jobs=1, output=output, **options)
