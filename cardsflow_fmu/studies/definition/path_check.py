"""Check of a study's paths in its experiment."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.experiment.config.key_path import PathError, split_path
from cardsflow_fmu.experiment.experiment import Experiment


class PathCheck:
    """A check of paths in an experiment."""

    def __init__(self, path: Path, settings: Mapping[str, Any]) -> None:
        self._path, self._settings = path, settings

    @cached_property
    def base(self) -> Experiment:
        """The experiment without variations; raises InputError if it is invalid."""
        base = Experiment.load(self._path, self._settings, names_files=False)
        require_simulated(base)
        return base

    def require(self, path: str, value: Any) -> None:
        """Reject a path that does not exist. An invalid value is not rejected, but fails its run.

        Raises:
            UnknownNameError: A part of the path does not exist; the message suggests a name.
            PathError: A part of the path is not a table.
        """
        _ = self.base
        try:
            Experiment.load(self._path, {**self._settings, path: value}, names_files=False)
        except PathError:
            raise
        except UnknownNameError as error:
            is_value = isinstance(value, str) and error.name == value
            if error.key is not None and _leads_through(path, error.key) and not is_value:
                raise
        except InputError:
            pass


def require_simulated(experiment: Experiment) -> None:
    """Reject an experiment with a real robot, which requires supervision."""
    hardware = experiment.hardware
    if hardware.use and not hardware.is_emulated:
        problem = "must be false in a study, unless hardware.link is 'emulated:'"
        raise InputError(problem, file=experiment.file, key="hardware.use")


def _leads_through(path: str, key: str) -> bool:
    """Return whether the key of an error is a part of the path; keys have no quotes."""
    plain = ".".join(split_path(path))
    return plain == key or plain.startswith((f"{key}.", f"{key}["))
