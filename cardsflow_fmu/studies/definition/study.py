"""Study: an experiment, what is varied, how it is sampled, and what is looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .reader import STUDY_FILE, read_study
from .tables import Box, Optimise, Sampler, TableKind
from .variations import Variation


@dataclass(frozen=True)
class Study:
    """A study, complete and checked.

    Attributes:
        file: Where it comes from.
        experiment: The experiment.toml, or the folder that holds one.
        settings: Changes to it that all runs share, by full key; `run.compute` and `run.coupling`
            are among them.
        seed: Where all random numbers come from.
        variations: What is varied.
        sampler: How the variations are combined.
        count: How many samples; None for `grid` and `list`.
        metrics: What is looked at, `*` spelled out.
        box: Where the workspace is looked at; None for the joint limits.
        optimise: A search; None for a sampling.
        output: Folder for runs, table and report.
        tables: Kinds of the table.
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
    tables: tuple[TableKind, ...] = ("csv",)

    @property
    def name(self) -> str:
        """Name of its file, without the ending; that of its folder for a study.toml."""
        own = self.file.stem
        return self.file.resolve().parent.name if own == STUDY_FILE.stem else own

    @property
    def compute(self) -> str:
        """Who computes."""
        return str(self.settings["run.compute"])

    @property
    def coupling(self) -> str:
        """How the models are coupled."""
        return str(self.settings["run.coupling"])

    @staticmethod
    def load(path: str | Path) -> Study:
        """Read a study.

        Args:
            path: A study.toml, or the folder that holds one.

        Raises:
            InputError: Something in it, or in its experiment, is wrong; file and key are named.
        """
        return Study(**read_study(Path(path)))
