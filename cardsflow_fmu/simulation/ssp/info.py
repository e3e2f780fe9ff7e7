"""Information about the system of FMUs in an .ssp file, as data and as text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from cardsflow_fmu.utils.temporary import temporary_folder
from cardsflow_fmu.utils.text_table import table

from .reader import name_archive_in_errors, read_system, unpack_ssp
from .system import Component


def system_info(path: str | Path) -> dict[str, Any]:
    """Return components and connections of a system as plain data."""
    path = Path(path)
    with temporary_folder() as scratch, name_archive_in_errors(path, scratch) as folder:
        unpack_ssp(path, folder)
        system = read_system(folder)
        variants = sorted(file.stem for file in folder.glob("*.ssd"))
    return {
        "name": system.name,
        "step": system.step,
        "stop_time": system.stop_time,
        "variants": [name for name in variants if name != "SystemStructure"],
        "components": [
            {
                "name": component.name,
                "fmu": component.source,
                "inputs": _names(component, "input"),
                "outputs": _names(component, "output"),
            }
            for component in system.components
        ],
        "connections": [
            {"from": ".".join(one.source), "to": ".".join(one.target)} for one in system.connections
        ],
        "units": {"step": "s", "stop_time": "s"},
    }


def describe_system(info: dict[str, Any]) -> str:
    """Return the information about a system as tables of text."""
    times = [
        f"{label} {value:g} s"
        for label, value in (("step", info["step"]), ("until", info["stop_time"]))
        if value is not None
    ]
    count = len(info["components"])
    title = ", ".join([f"{info['name']}: a system of {count} FMUs", *times])
    components = [
        [c["name"], c["fmu"], str(len(c["inputs"])), str(len(c["outputs"]))]
        for c in info["components"]
    ]
    sections = [title, table(["component", "FMU", "inputs", "outputs"], components)]
    connections = [[one["from"], one["to"]] for one in info["connections"]]
    sections.append(table(["from", "to"], connections))
    if info["variants"]:
        sections.append(f"variants: {', '.join(info['variants'])}")
    return "\n\n".join(section for section in sections if section)


def _names(component: Component, kind: str) -> list[str]:
    return [connector.name for connector in component.connectors if connector.kind == kind]
