"""Information about robots and FMUs, as data and as text."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import WORLD, CardsflowError, Muscle, Robot, Vector3, read_robot
from addin_sdfusion.robot.checks.not_simulated import not_simulated
from addin_sdfusion.robot.model.muscle_laws import law_of, states_of
from cardsflow_fmu.utils.text_table import table
from sim_dart.muscles.paths import MusclePaths


def robot_info(path: str | Path, cable_set: str | None = None) -> dict[str, Any]:
    """Return links, joints, muscles and task frames of a robot as plain data in SI units.

    Unlimited values are infinite.

    Args:
        path: Robot file or its folder.
        cable_set: Name of the cable set (default: as in the robot file).
    """
    robot = read_robot(path, cable_set)
    lengths, problems = _lengths(robot)
    return {
        "name": robot.name,
        "mass": sum(link.inertia.mass for link in robot.links),
        "reach": _max_reach(robot),
        "links": [{"name": link.name, "mass": link.inertia.mass} for link in robot.links],
        "joints": _rows(robot.joints, "name type parent child"),
        "coordinates": _rows(
            robot.coordinates,
            "name unit lower upper initial damping actuated tau_min tau_max stiffness rest "
            "friction",
        ),
        "not_simulated": [*problems, *not_simulated(robot)],
        "cable_set": robot.cable_set,
        "cable_sets": [cable_set.name for cable_set in robot.cable_sets],
        "muscles": [
            {
                "name": muscle.name,
                "via_points": len(muscle.via_points),
                "links": list(dict.fromkeys(point.link for point in muscle.via_points)),
                "model": muscle.model.kind,
                "command": _command(muscle),
                "states": [f"{state.name} [{state.unit}]" for state in states_of(muscle.model)],
                "f_min": muscle.f_min,
                "f_max": muscle.f_max,
                "length": length,
            }
            for muscle, length in zip(robot.muscles, lengths, strict=True)
        ],
        "operational_space": robot.task_set,
        "operational_spaces": [task_set.name for task_set in robot.task_sets],
        "task_frames": [
            {"name": frame.name, "link": frame.link, "axes": list(frame.axes)}
            for frame in robot.task_frames
        ],
        "units": {"mass": "kg", "reach": "m", "length": "m", "f_min": "N", "f_max": "N"},
    }


def _rows(items: Iterable[object], attributes: str) -> list[dict[str, Any]]:
    return [{name: getattr(item, name) for name in attributes.split()} for item in items]


def _lengths(robot: Robot) -> tuple[list[float] | list[None], list[str]]:
    """Return the path lengths at the initial pose, in [m], and problems that prevent it."""
    try:
        paths = MusclePaths(robot)
    except CardsflowError as error:
        return [None] * len(robot.muscles), [str(error)]
    return paths.evaluate([c.initial for c in robot.coordinates]).lengths.tolist(), []


def fmu_info(path: str | Path) -> dict[str, Any]:
    """Return the variables of an FMU as plain data."""
    import fmpy  # only required for FMUs

    from cardsflow_fmu.cosim.fmu_description import read_description

    description = read_description(Path(path))
    return {
        "name": description.modelName,
        "fmi_version": description.fmiVersion,
        "description": description.description,
        "generated_by": description.generationTool,
        "platforms": sorted(fmpy.supported_platforms(str(path))),
        "variables": _rows(
            description.modelVariables, "name causality variability unit start description"
        ),
    }


def robot_title(info: dict[str, Any]) -> str:
    """Return name, numbers of parts, mass and reach of a robot in one line."""
    motors = sum(c["actuated"] for c in info["coordinates"])
    return (
        f"{info['name']}: {len(info['links'])} links, {len(info['coordinates'])} coordinates, "
        f"{len(info['muscles'])} muscles, {f'{motors} motors, ' if motors else ''}"
        f"{info['mass']:.6g} kg, reach {info['reach']:.4g} m"
    )


def robot_tables(info: dict[str, Any]) -> list[tuple[list[str], list[list[Any]]]]:
    """Return the tables of a robot, each with titles and rows."""
    return [
        (
            ["joint", "type", "parent", "child"],
            [[j["name"], j["type"], j["parent"], j["child"]] for j in info["joints"]],
        ),
        (
            ["coordinate", "unit", "lower", "upper", "initial"],
            [
                [c["name"], c["unit"], c["lower"], c["upper"], c["initial"]]
                for c in info["coordinates"]
            ],
        ),
        (
            ["motor", "tau_min", "tau_max", "unit"],
            [
                [
                    c["name"],
                    c["tau_min"],
                    c["tau_max"],
                    "N·m" if c["unit"] == "rad" else "N",
                ]
                for c in info["coordinates"]
                if c["actuated"]
            ],
        ),
        (
            ["muscle", "cable", "command", "f_min [N]", "f_max [N]", "length [m]", "links"],
            [
                [
                    *(m["name"], m["model"], m["command"] or "none"),
                    *(m["f_min"], m["f_max"]),
                    "" if m["length"] is None else m["length"],
                    " - ".join(m["links"]),
                ]
                for m in info["muscles"]
            ],
        ),
        (
            ["task frame", "link", "axes"],
            [[f["name"], f["link"], " ".join(f["axes"])] for f in info["task_frames"]],
        ),
    ]


def describe_robot(info: dict[str, Any]) -> str:
    """Return the information about a robot as tables of text."""
    sections = [*(f"WARNING: {line}" for line in info["not_simulated"]), robot_title(info)]
    sections += [
        table(heads, [list(map(_text, row)) for row in rows]) for heads, rows in robot_tables(info)
    ]
    for kind, active in (("cable_sets", "cable_set"), ("operational_spaces", "operational_space")):
        if info[kind]:
            names = [f"{name} (active)" if name == info[active] else name for name in info[kind]]
            sections.append(f"{kind.replace('_', ' ')}: {', '.join(names)}")
    return "\n\n".join(section for section in sections if section)


def describe_fmu(info: dict[str, Any]) -> str:
    """Return the information about an FMU as tables of text."""
    title = (
        f"{info['name']}: {info['description']}, FMI {info['fmi_version']}, "
        f"for {', '.join(info['platforms']) or 'no platform'}"
    )
    rows = [
        [v["name"], v["causality"], v["variability"], v["unit"] or "", v["start"] or ""]
        for v in info["variables"]
    ]
    return f"{title}\n\n{table(['variable', 'causality', 'variability', 'unit', 'start'], rows)}"


def _max_reach(robot: Robot) -> float:
    """Return the maximum length of a stretched chain to an end or a centre of mass, in [m]."""
    length = {WORLD: 0.0}  # length of the chain to the joint of each link
    joint_position: dict[str, Vector3] = {}
    longest = 0.0
    for joint in robot.joints:
        chain = length[joint.parent]
        if joint.parent in joint_position:
            chain += math.dist(joint_position[joint.parent], joint.T_parent_joint.position)
        length[joint.child] = chain
        joint_position[joint.child] = joint.T_child_joint.position
        link = robot.link(joint.child)
        longest = max(
            longest, chain + math.dist(joint_position[joint.child], link.end or link.inertia.com)
        )
    return longest


def _command(muscle: Muscle) -> str | None:
    """Return the command of a muscle with its unit; None for a passive muscle."""
    command = law_of(muscle.model).command
    return None if command is None else f"{command.name} [{command.unit}]"


def _text(value: str | float) -> str:
    """Return a cell of a table as text."""
    if isinstance(value, str):
        return value
    return f"{value:.6g}".replace("inf", "unlimited")
