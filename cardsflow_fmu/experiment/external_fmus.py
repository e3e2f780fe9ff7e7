"""The table `fmus`: external FMUs, and the names of their variables."""

from __future__ import annotations

from pathlib import Path

from cardsflow_fmu.config.table import Table
from cardsflow_fmu.cosim.external_fmu import ExternalFmu
from cardsflow_fmu.signals.roles import HARDWARE, ROLES
from cardsflow_fmu.signals.units import KNOWN_UNITS


def read_fmus(table: Table) -> dict[str, ExternalFmu]:
    """The external FMUs that an experiment names, by their role.

    Args:
        table: The table `fmus`: a path, or a table with a path and a name map, for each role.

    Raises:
        InputError: Something in it is wrong.
    """
    roles = (*ROLES, HARDWARE)
    fmus = {role: _read_fmu(table, role) for role in roles if role in table}
    for role in roles:
        table.value(role, None)
    table.close()
    return fmus


def _read_fmu(table: Table, role: str) -> ExternalFmu:
    key = table.key(role)
    if isinstance(table.value(role), str):
        return ExternalFmu(_existing(table, role), key)
    own = table.table(role)
    fmu = ExternalFmu(
        _existing(own, "path"),
        key,
        _texts(own, "inputs"),
        _texts(own, "outputs"),
        _texts(own, "units"),
        {name: values.number(name) for values, name in _entries(own, "parameters")},
    )
    own.close()
    for name, unit in fmu.units.items():
        if unit not in KNOWN_UNITS:
            raise own.table("units").unknown(name, "unit", unit, KNOWN_UNITS)
    return fmu


def _existing(table: Table, key: str) -> Path:
    file = table.file.parent / table.text(key)
    try:
        is_there = file.is_file()
    except OSError:  # such as a name that is too long
        is_there = False
    if not is_there:
        raise table.error(key, f"there is no file {file}")
    return file


def _texts(table: Table, key: str) -> dict[str, str]:
    return {name: values.text(name) for values, name in _entries(table, key)}


def _entries(table: Table, key: str) -> list[tuple[Table, str]]:
    values = table.table(key)
    return [(values, name) for name in table.value(key, {})]
