"""Actuators of an MJCF's tendons and joints: muscles, cables that pull, motors, tendon springs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from ...finding import Subject
from ...finding_builders import unknown
from ...formats.reading.xml import Node
from ...model.joint import Coordinate, Joint
from ...model.muscle import CableKind, CableModel, Muscle
from ...model.muscle_path import CoordinateTerm
from ...model.tension_laws import TENSION_LAWS
from ...transforms.joint_chains import Names
from .compiler import Compiler, numbers
from .drives import MUSCLE, TIMES, Drive
from .tendons import Tendon

KIND: CableKind = "mujoco_muscle"


class ActuatorReader:
    """Reads what drives a robot.

    Attributes:
        nodes: The elements of the muscles, by name.
    """

    def __init__(self, compiler: Compiler, tendons: Mapping[str, Tendon]) -> None:
        self._compiler, self._tendons = compiler, tendons
        self._names = Names()
        self.nodes: dict[str, Node] = {}

    def muscles(self, drives: Sequence[Drive], joints: Sequence[Joint]) -> Iterator[Muscle]:
        """The muscles and cables, in the order of the actuators, then springs of tendons."""
        known = [c.name for joint in joints for c in joint.coordinates]
        driven: set[str] = set()
        for k, drive in enumerate(drives):
            kind, target = drive.target
            if kind == "tendon" and target in self._tendons:
                driven.add(target)
                yield from self._on_tendon(drive, self._tendons[target])
            elif kind == "tendon":
                problem = unknown("tendon", target, list(self._tendons))
                drive.node.error("unknown-tendon", problem)
            elif kind == "joint" and drive.is_muscle and target in known:
                name = self._name(drive, f"actuator_{k + 1}")
                node = self.nodes[name] = drive.node.about(Subject("muscle", name))
                terms = (CoordinateTerm(target, 1.0),)
                yield Muscle(name, (), model=self._law(drive, node), terms=terms)
        for tendon in self._tendons.values():
            yield from self._spring(tendon)
            idle = tendon.name not in driven and not _has_spring(tendon.node)
            if idle:
                problem = f"tendon {tendon.name!r} has no actuator and no spring; left out"
                tendon.node.warning("tendon-left-out", problem)

    def with_motors(self, drives: Sequence[Drive], joints: Sequence[Joint]) -> list[Joint]:
        """The joints with their motors."""
        known = {c.name: c for joint in joints for c in joint.coordinates}
        for drive in drives:
            kind, target = drive.target
            if kind == "tendon" or (kind == "joint" and drive.is_muscle and target in known):
                continue
            if kind != "joint" or target not in known:
                name = drive.node.attribute("name", "")
                problem = f"actuator {name!r} drives {kind or 'nothing'} {target!r}; left out"
                drive.node.warning("actuator-left-out", problem)
            else:
                known[target] = self._motor(drive, known[target])
        return [
            replace(joint, coordinates=tuple(known[c.name] for c in joint.coordinates))
            for joint in joints
        ]

    def _name(self, drive: Drive, otherwise: str) -> str:
        return self._names.give(drive.node.attribute("name", "") or otherwise)

    def _on_tendon(self, drive: Drive, tendon: Tendon) -> Iterator[Muscle]:
        name = self._name(drive, tendon.name)
        node = self.nodes[name] = drive.node.about(Subject("muscle", name))
        muscle = _path(name, tendon)
        if drive.is_muscle:
            yield replace(muscle, model=self._law(drive, node))
            return
        low, high = self._forces(drive, node, -1.0)
        if low < 0.0:
            problem = f"it would push with up to {-low:g} N; a cable only pulls here"
            node.warning("cable-pulls-only", problem)
        yield replace(muscle, f_min=max(low, 0.0), f_max=max(high, 0.0))

    def _law(self, drive: Drive, node: Node) -> CableModel:
        """MuJoCo's muscle with its parameters; length_high 0 where no range is given."""
        gear = drive.gear
        if not gear > 0.0:
            node.error("unsupported-gear", f"a muscle with gear {gear:g} is not supported")
            gear = 1.0
        g = [*drive.gain_numbers, *MUSCLE[len(drive.gain_numbers) :]]
        b = [*drive.bias_numbers, *MUSCLE[len(drive.bias_numbers) :]]
        times = [*drive.dynamics_numbers, *TIMES[len(drive.dynamics_numbers) :]]
        lengths = drive.numbers("lengthrange")
        low, high = lengths if len(lengths) == 2 else (0.0, 0.0)
        control = drive.range_of(self._compiler, "ctrl") or (0.0, 1.0)
        if drive.range_of(self._compiler, "force") is not None:
            node.warning("force-range-left-out", "the range of its force is left out")
        values = {
            "force": gear * g[2] if g[2] >= 0.0 else g[2],
            "length_low": low / gear,
            "length_high": high / gear,
            "range_low": g[0],
            "range_high": g[1],
            "scale": g[3],
            "lmin": g[4],
            "lmax": g[5],
            "vmax": g[6],
            "fpmax": b[7] * _passive_part(g, b, node),
            "fvmax": g[8],
            "passive_range_low": b[0] if b[:2] != g[:2] else 0.0,
            "passive_range_high": b[1] if b[:2] != g[:2] else 0.0,
            "passive_lmax": b[5] if b[5] != g[5] else 0.0,
            "activation_time_constant": times[0],
            "deactivation_time_constant": times[1],
            "activation_width": times[2],
            "control_low": control[0],
            "control_high": control[1],
        }
        law = TENSION_LAWS[KIND].parameters
        pairs = [(p.name, values[p.name], p.default) for p in law if p.name in values]
        return CableModel(KIND, tuple((name, v) for name, v, default in pairs if v != default))

    def _forces(self, drive: Drive, node: Node, sign: float) -> tuple[float, float]:
        """The least and the largest force of an actuator on its target."""
        if (drive.gain, drive.dynamics) != ("fixed", "none"):
            problem = f"its {drive.gain} gain and {drive.dynamics} dynamics are left out"
            node.warning("actuator-simplified", f"{problem}: it is commanded by force here")
        elif drive.bias != "none":
            problem = (
                "its servo is left out: it is commanded by force here, not by position or speed"
            )
            node.warning("actuator-simplified", problem)
        plain = (drive.gain, drive.bias) == ("fixed", "none")
        scale = sign * drive.gear * ((*drive.gain_numbers, 1.0)[0] if plain else 1.0)
        control = drive.range_of(self._compiler, "ctrl") if plain else None
        force = drive.range_of(self._compiler, "force")
        ends = (-math.inf, math.inf) if control is None else control
        values = sorted((scale * ends[0], scale * ends[1])) if scale else [0.0, 0.0]
        if force is not None:
            bound = sorted((sign * drive.gear * force[0], sign * drive.gear * force[1]))
            values = [max(values[0], bound[0]), min(values[1], bound[1])]
        return values[0], values[1]

    def _motor(self, drive: Drive, c: Coordinate) -> Coordinate:
        node = drive.node.about(Subject("coordinate", c.name))
        if not c.is_free:
            node.warning("motor-left-out", "it follows another joint, or is held; no motor here")
            return c
        low, high = self._forces(drive, node, 1.0)
        if c.actuated:
            problem = "a second motor; both are one here, of both torques together"
            node.warning("motors-joined", problem)
            low, high = low + c.tau_min, high + c.tau_max
        else:
            low, high = max(low, c.tau_min), min(high, c.tau_max)
        return replace(c, actuated=True, tau_min=low, tau_max=high)

    def _spring(self, tendon: Tendon) -> Iterator[Muscle]:
        """The spring and damper of a tendon; its friction and limits are noted as left out."""
        node = tendon.node
        if node.number_attribute("frictionloss", 0.0) or node.number_attribute("armature", 0.0):
            node.warning("tendon-friction", "friction and armature of the tendon are left out")
        if self._compiler.limited(node, "limited", "range"):
            node.warning("tendon-limits", "the limits of the tendon's length are left out")
        if not _has_spring(node):
            return
        stiffness, damping = _number(node, "stiffness"), _number(node, "damping")
        rest = numbers(node, "springlength") or (-1.0,)
        low, high = rest[0], rest[-1]
        name = self._names.give(tendon.name)
        values = {"stiffness": stiffness, "rest_low": low, "rest_high": high, "damping": damping}
        model = CableModel("tendon_spring", tuple(values.items()))
        yield replace(_path(name, tendon), model=model)


def _path(name: str, tendon: Tendon) -> Muscle:
    return Muscle(
        name,
        tuple(tendon.points),
        wraps=tuple(tendon.wraps),
        branches=tuple(tendon.branches),
        terms=tuple(tendon.terms),
    )


def _has_spring(node: Node) -> bool:
    return bool(_number(node, "stiffness") or _number(node, "damping"))


def _number(node: Node, name: str) -> float:
    return (*numbers(node, name), 0.0)[0]


def _passive_part(gain: list[float], bias: list[float], node: Node) -> float:
    """The force that the passive curve counts in, over that of the active one; noted if unknown."""
    which = 2 if gain[2] >= 0.0 else 3  # F itself, or by scale, over the same acc0
    if gain[which] == bias[which] and gain[2] == bias[2]:
        return 1.0
    if (gain[2] >= 0.0) == (bias[2] >= 0.0) and gain[which] > 0.0:
        return bias[which] / gain[which]
    forces = f"its passive force is of {bias[2]:g} N, its active of {gain[2]:g} N"
    node.warning("passive-force", f"{forces}: the latter is both")
    return 1.0
