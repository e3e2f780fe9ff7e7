"""Reader of .ssp files: flat systems of co-simulation FMUs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from lxml import etree

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.units import Conversion, Unit, conversion
from cardsflow_fmu.utils.archive import require_inside, unpack_archive

from .parameters import read_parameters
from .system import Component, Connection, Connector, System
from .writer import FMU_TYPE
from .xml import decimal, local, parse, read_units


def unpack_ssp(path: Path, folder: Path) -> Path:
    """Unpack an .ssp file; names outside of the folder are rejected."""
    return unpack_archive(path, folder, ".ssp", "a system of FMUs")


@contextmanager
def name_archive_in_errors(path: Path, folder: Path) -> Iterator[Path]:
    """Replace unpacked files by their archive in errors of the context."""
    try:
        yield folder
    except InputError as error:
        if error.file is not None and error.file.is_relative_to(folder):
            error.file = path / error.file.relative_to(folder)
        raise


def read_system(folder: Path, variant: str | None = None) -> System:
    """Read the system structure of an unpacked .ssp.

    Args:
        folder: Folder of the unpacked archive.
        variant: Name of another .ssd (default: SystemStructure).

    Raises:
        InputError: The system is invalid or uses unsupported features.
    """
    structures = {file.stem: file for file in sorted(folder.glob("*.ssd"))}
    name = variant or "SystemStructure"
    if name not in structures:
        raise UnknownNameError("system structure", name, structures, file=folder)
    file = structures[name]
    root = parse(file)
    system = root.find("{*}System")
    if system is None:
        raise InputError(f"{local(root)} has no System", file=file, line=root.sourceline)
    units = read_units(root, file)
    components = [_component(element, folder, file, units) for element in _elements(system, file)]
    names = [component.name for component in components]
    if len(set(names)) < len(names):
        raise InputError("two components have the same name", file=file)
    parameters = read_parameters(system, file.parent, file)
    components = [_add_system_parameters(c, system_parameters=parameters) for c in components]
    unknown = {p.name.split(".", 1)[0] for p in parameters} - set(names)
    if unknown:
        raise UnknownNameError("component", sorted(unknown)[0], names, file=file)
    step, stop = _experiment(root, file)
    connections = tuple(_connections(system, components, file))
    return System(root.get("name", file.stem), tuple(components), connections, step, stop)


def _elements(system: Any, file: Path) -> list[Any]:
    elements: list[Any] = system.findall("{*}Elements/*")
    for element in elements:
        if local(element) != "Component":
            problem = f"{local(element)} {element.get('name', '')!r} inside the system"
            problem += ": only flat systems of FMUs are supported"
            raise InputError(problem, file=file, line=element.sourceline)
    if not elements:
        raise InputError("the system has no components", file=file)
    return elements


def _component(element: Any, folder: Path, file: Path, units: dict[str, Unit]) -> Component:
    name, source = element.get("name") or "", element.get("source") or ""
    line = element.sourceline
    if not name or "." in name:
        raise InputError(f"{name!r} is not a valid component name", file=file, line=line)
    if element.get("type", FMU_TYPE) != FMU_TYPE:
        raise InputError(f"component {name} is not an FMU", file=file, line=line)
    if element.get("implementation", "any") not in ("any", "CoSimulation"):
        problem = f"component {name} is a model-exchange FMU, which is not supported"
        raise InputError(problem, file=file, line=line)
    require_inside(source, file)
    if not (folder / source).is_file():
        raise InputError(
            f"component {name}: {source!r} does not exist in the archive", file=file, line=line
        )
    connectors = [
        _connector(one, units, file)
        for one in element.iterfind("{*}Connectors/{*}Connector")
        if one.get("kind") in ("input", "output")
    ]
    return Component(
        name, source, tuple(connectors), tuple(read_parameters(element, file.parent, file))
    )


def _connector(element: Any, units: dict[str, Unit], file: Path) -> Connector:
    kind: Literal["input", "output"] = "input" if element.get("kind") == "input" else "output"
    typed = list(element.iterchildren(tag=etree.Element))
    name = local(typed[0]) if typed else "Real"
    unit = typed[0].get("unit") if typed else None
    if unit is not None and unit not in units:
        raise UnknownNameError("unit", unit, units, file=file, line=element.sourceline)
    return Connector(element.get("name") or "", kind, name, units[unit] if unit else None)


def _add_system_parameters(component: Component, *, system_parameters: list[Any]) -> Component:
    """Return a component with the parameters of the system, followed by its own parameters."""
    lead = f"{component.name}."
    parameters = [
        replace(p, name=p.name.removeprefix(lead))
        for p in system_parameters
        if p.name.startswith(lead)
    ]
    names = {p.name for p in parameters}
    others = [p for p in component.parameters if p.name not in names]
    return replace(component, parameters=(*others, *parameters))


def _experiment(root: Any, file: Path) -> tuple[float | None, float | None]:
    """Return step and stop time; None if not specified."""
    experiment = root.find("{*}DefaultExperiment")
    if experiment is None:
        return None, None
    start = decimal(experiment, "startTime", file, default=0.0)
    if start != 0.0:
        raise InputError("a start time other than 0 is not supported", file=file)
    stop = decimal(experiment, "stopTime", file) if "stopTime" in experiment.attrib else None
    for algorithm in experiment.iter("{*}FixedStepAlgorithm"):
        return decimal(algorithm, "baseStepSize", file), stop
    return None, stop


def _connections(system: Any, components: list[Component], file: Path) -> Iterator[Connection]:
    """Yield the connections between components; connectors of the system are ignored."""
    ports = {(c.name, one.name): one for c in components for one in c.connectors}
    fed: set[tuple[str, str]] = set()
    for element in system.iterfind("{*}Connections/{*}Connection"):
        ends = [
            (element.get(f"{end}Element"), element.get(f"{end}Connector") or "")
            for end in ("start", "end")
        ]
        if None in (ends[0][0], ends[1][0]):
            continue
        for end in ends:
            if end not in ports:
                names = [".".join(one) for one in ports]
                wrong = ".".join(str(name) for name in end)
                raise UnknownNameError(
                    "connector", wrong, names, file=file, line=element.sourceline
                )
        source, target = sorted(ends, key=lambda end: ports[end].kind == "input")
        if ports[source].kind == "input" or ports[target].kind == "output" or target in fed:
            problem = f"{'.'.join(source)} cannot be connected to {'.'.join(target)}"
            raise InputError(problem, file=file, line=element.sourceline)
        fed.add(target)
        yield _connection(element, ports, source, target, file)


def _connection(
    element: Any,
    ports: dict[tuple[str, str], Connector],
    source: tuple[str, str],
    target: tuple[str, str],
    file: Path,
) -> Connection:
    units = ports[source].unit, ports[target].unit
    change = Conversion()
    if element.get("suppressUnitConversion", "false") not in ("true", "1") and None not in units:
        try:
            change = conversion(*units)
        except InputError as error:
            route = f"{'.'.join(source)} -> {'.'.join(target)}"
            raise InputError(
                f"{route}: {error.problem}", file=file, line=element.sourceline
            ) from None
    for child in element.iterchildren(tag=etree.Element):
        if local(child) == "LinearTransformation":
            factor = decimal(child, "factor", file, default=1.0)
            offset = decimal(child, "offset", file, default=0.0)
            change = Conversion(factor * change.factor, factor * change.offset + offset)
        elif local(child).endswith("Transformation"):
            problem = f"a {local(child)} is not supported"
            raise InputError(problem, file=file, line=child.sourceline)
    return Connection(source, target, change)
