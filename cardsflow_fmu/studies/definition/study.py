"""Study: an experiment with variations, a sampler or optimisation, and metrics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .reader import STUDY_FILE, read_study
from .tables import Box, Optimise, Sampler
from .variations import Variation


@dataclass(frozen=True)
class Study:
    """A study, complete and checked.

    Attributes:
        experiment: An experiment.toml, or its folder.
        settings: Changes of settings for all runs, by full key, including `run.compute` and
            `run.coupling`.
        seed: Seed of all random numbers.
        sampler: Method that combines the variations.
        count: Number of samples; None for `grid` and `list`.
        metrics: Names of the metrics, with `*` expanded.
        box: Joint positions of the workspace, or None for the joint limits.
        optimise: Settings of an optimisation, or None for a sampling.
        output: Folder for runs, table and report.
    """

    file: Path
    experiment: Path
    settings: Mapping[str, Any]
    seed: int
    variations: tuple[Variation, ...]
    sampler: Sampler
    count: int | None
    metrics: tuple[str, ...]
    box: Box | None
    optimise: Optimise | None
    output: Path

    @property
    def name(self) -> str:
        """Name of the file without suffix; for a study.toml the name of its folder."""
        stem = self.file.stem
        return self.file.resolve().parent.name if stem == STUDY_FILE.stem else stem

    @property
    def compute(self) -> str:
        """Engine that computes the models, see `run.compute`."""
        return str(self.settings["run.compute"])

    @staticmethod
    def load(path: str | Path) -> Study:
        """Read a study.

        Args:
            path: A study.toml, or its folder.

        Raises:
            InputError: The study or its experiment is invalid; the message states file and key.
        """
        return Study(**read_study(Path(path)))
