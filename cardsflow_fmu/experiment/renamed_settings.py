"""Renamed settings: errors for old keys, and conversion of old experiment files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from cardsflow_fmu.experiment.config.key_path import PathError, split_index

RENAMED_SETTINGS = {
    "estimator.exact": "estimator.exact_transition",
    "estimator.feeds": "estimator.feedback",
    "estimator.largest_innovation": "estimator.max_innovation",
    "estimator.largest_sd": "estimator.max_sd",
    "estimator.search": "estimator.find_start",
    "estimator.slack": "estimator.min_tension",
    "estimator.starts": "estimator.start_candidates",
    "estimator.units": "estimator.imus",
    "hardware.emulator.differences": "hardware.emulator.differentiate_positions",
    "hardware.tension_max": "hardware.max_tension",
    "world.objects.spin": "world.objects.angular_velocity",
}
"""New key by old key, without indices of rows. Only the last part of a key differs."""


def reject_renamed(data: Mapping[str, Any], file: Path) -> None:
    """Reject old keys with an error that names the new key.

    Args:
        data: The content of an experiment.toml, with the changes of `--set`.
        file: The experiment.toml, for messages.

    Raises:
        PathError: The data contains an old key.
    """
    errors = []
    for old, new in RENAMED_SETTINGS.items():
        *path, last = old.split(".")
        for table in _tables(data, path):
            if any(split_index(name)[0] == last for name in table):
                errors.append(PathError(f"was renamed to {new}", file=file, key=old))
    if errors:
        first, *others = errors
        first.more = tuple(others)
        raise first


def rename_old_keys(data: dict[str, Any]) -> None:
    """Replace the old keys of an experiment.json that an earlier version has written.

    Args:
        data: The content of the file; changed in place.
    """
    run = data.get("run")
    if isinstance(run, dict) and "coupling" in run:
        run["scheme"] = run.pop("coupling")
    for old, new in RENAMED_SETTINGS.items():
        *path, last = old.split(".")
        name = new.rpartition(".")[2]
        for table in _tables(data, path):
            if last in table and name not in table:
                table[name] = table.pop(last)


def _tables(data: Any, path: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield the tables at a path, including each row of an array of tables."""
    if isinstance(data, list):
        for row in data:
            yield from _tables(row, path)
    elif isinstance(data, dict) and not path:
        yield data
    elif isinstance(data, dict):
        for name, inner in data.items():
            if split_index(name)[0] == path[0]:
                yield from _tables(inner, path[1:])
