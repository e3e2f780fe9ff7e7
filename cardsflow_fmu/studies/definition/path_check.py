"""The check of a study's paths on its experiment."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.experiment.config.key_path import PathError, split_path
from cardsflow_fmu.experiment.experiment import Experiment


class PathCheck:
    """A check of paths on an experiment.

    Args:
        path: The experiment.toml, or the folder that holds one.
        settings: Changes to it that all runs share.
    """

    def __init__(self, path: Path, settings: Mapping[str, Any]) -> None:
        self._path, self._settings = path, settings

    @cached_property
    def base(self) -> Experiment:
        """The experiment without variations; InputError if something is wrong with it."""
        base = Experiment.load(self._path, self._settings, names_files=False)
        require_simulated(base)
        return base

    def require(self, path: str, value: Any) -> None:
        """Reject a path that leads nowhere; a value that does not fit is the run's own trouble.

        Args:
            path: The full key.
            value: A value for it.

        Raises:
            UnknownNameError: A part of the path names nothing; the nearest is named.
            PathError: The path leads through what is not a table.
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
    """Reject an experiment that drives a real robot, which must be supervised.

    Args:
        experiment: Of a study, or of one of its runs.

    Raises:
        InputError: It does.
    """
    hardware = experiment.hardware
    if hardware.use and not hardware.is_emulated:
        what = "a study drives no robot; leave it false, or set hardware.link to 'emulated:'"
        raise InputError(what, file=experiment.file, key="hardware.use")


def _leads_through(path: str, key: str) -> bool:
    """Return whether an error about a key is about a part of the path; keys have no quotes."""
    plain = ".".join(split_path(path))
    return plain == key or plain.startswith((f"{key}.", f"{key}["))
