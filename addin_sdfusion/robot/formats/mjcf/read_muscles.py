"""Reader of MJCF tendons and actuators: muscles, cables, motors, tendon springs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from ...finding import Subject
from ...model.joint import Coordinate, Joint
from ...model.laws import MUSCLE_LAWS
from ...model.muscle import CableKind, CableModel, Muscle, ViaPoint, Wrap, WrapSurface
from ...model.muscle_path import Branch, CoordinateTerm
from ...transforms.joint_chains import Names
from ..reading.xml import Node
from .compiled import Compiled, Row, transform, vector
from .document import Document
from .read_equalities import is_distance

KIND: CableKind = "mujoco_muscle"
ON_JOINTS = ("joint", "jointinparent")


@dataclass
class Tendon:
    """Tendon of the model.

    Attributes:
        muscle: Path of the tendon, as a muscle without a muscle law.
        is_driven: Whether an actuator drives it.
    """

    row: Row
    node: Node
    muscle: Muscle
    is_driven: bool = field(default=False)

    @property
    def has_spring(self) -> bool:
        """Return whether the tendon has stiffness or damping."""
        return bool(self.row["stiffness"] or self.row["damping"])


class MuscleReader:
    """Reader of the actuators and tendons of a robot.

    Attributes:
        surfaces: Wrap surfaces of tendons, by name.
        used_sites: Indices of the sites on tendons.
    """

    def __init__(self, document: Document, compiled: Compiled, joints: Sequence[Joint]) -> None:
        self._document, self._compiled = document, compiled
        self._names = Names()
        self._coordinates = {c.name: c for joint in joints for c in joint.coordinates}
        self.surfaces: dict[str, WrapSurface] = {}
        self.used_sites: set[int] = set()
        self._tendons = [self._tendon(row) for row in compiled.tendons]
        rows = [row for row in compiled.equalities if is_distance(row, compiled)]
        self._fixed_tendons = {compiled.tendons[row["obj1id"]]["name"] for row in rows}

    def read(self) -> tuple[tuple[Muscle, ...], dict[str, Coordinate]]:
        """Return the muscles, and the coordinates with their motors by name.

        The muscles are in the order of the actuators, followed by tendon springs.
        """
        rows = enumerate(self._compiled.actuators)
        muscles = [muscle for k, row in rows for muscle in self._read_actuator(k, row)]
        for tendon in self._tendons:
            muscles += self._spring(tendon)
        return tuple(muscles), self._coordinates

    def _read_actuator(self, number: int, row: Row) -> Iterator[Muscle]:
        """Yield the muscle of an actuator; for a motor, update its coordinate instead."""
        node, target = self._document.node_at(row["line"]), row["trnid"][0]
        joint = self._compiled.joints[target]["name"] if row["trntype"] in ON_JOINTS else ""
        if row["delay"]:
            node.warning("actuator-simplified", "its delay is omitted")
        if row["trntype"] == "tendon":
            self._tendons[target].is_driven = True
            if row["armature"] or row["damping"]:
                node.warning("tendon-friction", "armature and damping of the actuator are omitted")
            yield self._tendon_muscle(row, node, self._tendons[target].muscle)
        elif joint not in self._coordinates:
            problem = f"actuator {row['name']!r} drives {row['trntype']} {joint!r}; omitted"
            node.warning("actuator-left-out", problem)
        else:
            self._add_resistance(row, joint)
            if is_muscle(row):
                name = self._names.unique(row["name"] or f"actuator_{number + 1}")
                node = node.with_subject(Subject("muscle", name))
                terms = (CoordinateTerm(joint, 1.0),)
                yield Muscle(name, (), model=_law(row, node), terms=terms)
            else:
                self._coordinates[joint] = _with_motor(row, node, self._coordinates[joint])

    def _add_resistance(self, row: Row, joint: str) -> None:
        """Add the armature and damping of an actuator to its joint."""
        c, gear = self._coordinates[joint], row["gear"][0]
        armature, damping = gear * gear * row["armature"], gear * gear * row["damping"]
        self._coordinates[joint] = replace(
            c, armature=c.armature + armature, damping=c.damping + damping
        )

    def _tendon_muscle(self, row: Row, node: Node, path: Muscle) -> Muscle:
        name = self._names.unique(row["name"] or path.name)
        node = node.with_subject(Subject("muscle", name))
        muscle = replace(path, name=name)
        if is_muscle(row):
            return replace(muscle, model=_law(row, node))
        low, high = _forces(row, node, -1.0)
        if low < 0.0:
            problem = f"it could push with up to {-low:g} N; a cable can only pull here"
            node.warning("cable-pulls-only", problem)
        return replace(muscle, f_min=max(low, 0.0), f_max=max(high, 0.0))

    def _spring(self, tendon: Tendon) -> Iterator[Muscle]:
        """Yield the spring and damper of a tendon; report its friction and limits as omitted."""
        row, node = tendon.row, tendon.node
        if row["frictionloss"] or row["armature"]:
            node.warning("tendon-friction", "friction and armature of the tendon are omitted")
        if row["limited"]:
            node.warning("tendon-limits", "the limits of the tendon length are omitted")
        if row["actfrclimited"]:
            node.warning("tendon-limits", "the limits of the tendon force are omitted")
        if any(row["stiffnesspoly"]) or any(row["dampingpoly"]) or row["springyield"]:
            problem = "only the first coefficients of its stiffness and damping are used"
            node.warning("polynomial-left-out", problem)
        if not (tendon.is_driven or tendon.has_spring or tendon.row["name"] in self._fixed_tendons):
            name = tendon.muscle.name
            problem = f"tendon {name!r} has no actuator and no spring; omitted"
            node.warning("tendon-left-out", problem)
        if not tendon.has_spring:
            return
        low, high = row["lengthspring"]
        values = {
            "stiffness": row["stiffness"],
            "rest_low": low,
            "rest_high": high,
            "damping": row["damping"],
        }
        model = CableModel("tendon_spring", tuple(values.items()))
        yield replace(tendon.muscle, name=self._names.unique(tendon.muscle.name), model=model)

    def _tendon(self, row: Row) -> Tendon:
        points: list[ViaPoint] = []
        wraps: list[Wrap] = []
        branches: list[Branch] = []
        terms: list[CoordinateTerm] = []
        repeated: list[str] = []
        for wrap in self._compiled.wraps[row["adr"] : row["adr"] + row["num"]]:
            item, number = wrap["objid"], wrap["prm"]
            if wrap["type"] == "joint":
                terms.append(CoordinateTerm(self._compiled.joints[item]["name"], number))
            elif wrap["type"] == "pulley":
                branches.append(Branch(len(points), number))
            elif wrap["type"] == "site":
                point = self._site(item)
                if _repeats(point, points, wraps, branches):
                    repeated.append(self._compiled.sites[item]["name"])
                else:
                    points.append(point)
            else:
                side = self._site(int(number)) if number >= 0.0 else None
                name = self._surface(self._compiled.geoms[item])
                wraps.append(Wrap(name, len(points) - 1, rule="mujoco", side_point=side))
        name = row["name"]
        node = self._document.node_at(row["line"]).with_subject(Subject("muscle", name))
        if repeated:
            problem = f"sites at the position of the site before them are ignored: {repeated}"
            node.warning("repeated-via-point", problem)
        more = (tuple(wraps), tuple(branches), tuple(terms))
        muscle = Muscle(name, tuple(points), wraps=more[0], branches=more[1], terms=more[2])
        return Tendon(row, node, muscle)

    def _site(self, number: int) -> ViaPoint:
        self.used_sites.add(number)
        row = self._compiled.sites[number]
        return ViaPoint(self._compiled.bodies[row["bodyid"]]["name"], vector(row["pos"]))

    def _surface(self, row: Row) -> str:
        """Return the name of the surface of a geom; cylinders are infinite in MuJoCo."""
        name, link = row["name"], self._compiled.bodies[row["bodyid"]]["name"]
        shape, radius = row["type"], row["size"][0]
        pose = transform(row).pose()
        self.surfaces[name] = WrapSurface(name, link, shape, radius, pose, math.inf)
        return str(name)


def _repeats(
    point: ViaPoint, points: list[ViaPoint], wraps: list[Wrap], branches: list[Branch]
) -> bool:
    """Return whether a point ends a segment of length 0 without a wrap."""
    last = len(points) - 1
    starts_branch = bool(branches) and branches[-1].point > last
    is_wrapped = bool(wraps) and wraps[-1].segment == last
    return bool(points) and point == points[-1] and not starts_branch and not is_wrapped


def is_muscle(row: Row) -> bool:
    """Return whether an actuator is a MuJoCo muscle."""
    return (row["gaintype"], row["biastype"], row["dyntype"]) == ("muscle",) * 3


def _law(row: Row, node: Node) -> CableModel:
    """Return the MuJoCo muscle law with its parameters."""
    gear = row["gear"][0]
    if not gear > 0.0:
        node.error("unsupported-gear", f"a muscle with gear {gear:g} is not supported")
        gear = 1.0
    if row["forcelimited"]:
        node.warning("force-range-left-out", "the range of its force is omitted")
    gain, bias, times = row["gainprm"], row["biasprm"], row["dynprm"]
    low, high = _lengths(row, node, gear)
    # MuJoCo limits the command of a muscle to [0, 1] in addition to its range
    control = [min(max(x, 0.0), 1.0) for x in row["ctrlrange"] or (0.0, 1.0)]
    values = {
        "length_low": low,
        "length_high": high,
        "range_low": gain[0],
        "range_high": gain[1],
        "lmin": gain[4],
        "lmax": gain[5],
        "vmax": gain[6],
        "fpmax": bias[7] * _passive_force_ratio(gain, bias, node),
        "fvmax": gain[8],
        "passive_range_low": bias[0] if bias[:2] != gain[:2] else 0.0,
        "passive_range_high": bias[1] if bias[:2] != gain[:2] else 0.0,
        "passive_lmax": bias[5] if bias[5] != gain[5] else 0.0,
        "activation_time_constant": times[0],
        "deactivation_time_constant": times[1],
        "activation_width": times[2],
        "control_low": control[0],
        "control_high": control[1],
    }
    if gain[2] >= 0.0:
        values |= {"force": gear * gain[2], "scale": gain[3]}
    elif row["acc0"] > 0.0:  # acceleration from a unit force at the reference pose
        values["force"] = gear * gain[3] / row["acc0"]
    else:
        values |= {"scale": gain[3], "acc0": 0.0}
    law = MUSCLE_LAWS[KIND].parameters
    pairs = [(p.name, values[p.name], p.default) for p in law if p.name in values]
    return CableModel(KIND, tuple((name, v) for name, v, default in pairs if v != default))


def _lengths(row: Row, node: Node, gear: float) -> tuple[float, float]:
    """Return the range of the tendon length, specified or found over the joint ranges."""
    low, high = row["lengthrange"]
    if low < high:
        return low / gear, high / gear
    if row["foundrange"] is None:
        problem = (
            "no lengthrange, and none found: joints and tendon without ranges, or too many "
            "muscles; set lengthrange of the actuator"
        )
        node.error("no-length-range", problem)
        return 0.0, 1.0
    low, high = row["foundrange"]
    problem = (
        f"no lengthrange: {low:.6g} to {high:.6g} m from joint or tendon ranges is used; "
        "the value that MuJoCo simulates may differ by some percent; specify it if needed"
    )
    node.warning("length-range-found", problem)
    return low, high


def _passive_force_ratio(gain: Sequence[float], bias: Sequence[float], node: Node) -> float:
    """Return the ratio of passive to active peak force; report it if it is unknown."""
    which = 2 if gain[2] >= 0.0 else 3  # the force itself, or the scale over the same acc0
    if gain[which] == bias[which] and gain[2] == bias[2]:
        return 1.0
    if (gain[2] >= 0.0) == (bias[2] >= 0.0) and gain[which] > 0.0:
        return bias[which] / gain[which]
    forces = f"its passive force is {bias[2]:g} N, its active force {gain[2]:g} N"
    node.warning("passive-force", f"{forces}; the active force is used for both")
    return 1.0


def _forces(row: Row, node: Node, sign: float) -> tuple[float, float]:
    """Return the minimum and maximum force of an actuator on its target."""
    gain, bias, dynamics = row["gaintype"], row["biastype"], row["dyntype"]
    if (gain, dynamics) != ("fixed", "none"):
        problem = f"its {gain} gain and {dynamics} dynamics are omitted"
        node.warning("actuator-simplified", f"{problem}; here it is commanded by force")
    elif bias != "none":
        problem = "its servo is omitted; here it is commanded by force, not position or velocity"
        node.warning("actuator-simplified", problem)
    gear = row["gear"][0]
    is_plain = (gain, bias) == ("fixed", "none")
    scale = sign * gear * (row["gainprm"][0] if is_plain else 1.0)
    ends = (row["ctrlrange"] if is_plain else None) or (-math.inf, math.inf)
    values = sorted((scale * ends[0], scale * ends[1])) if scale else [0.0, 0.0]
    if row["forcelimited"]:
        bound = sorted(sign * gear * end for end in row["forcerange"])
        values = [max(values[0], bound[0]), min(values[1], bound[1])]
    return values[0], values[1]


def _with_motor(row: Row, node: Node, c: Coordinate) -> Coordinate:
    node = node.with_subject(Subject("coordinate", c.name))
    if not c.is_free:
        node.warning("motor-left-out", "its joint is coupled or locked; the motor is omitted")
        return c
    low, high = _forces(row, node, 1.0)
    if c.actuated:
        problem = "a second motor; both are combined into one with the sum of both torques"
        node.warning("motors-joined", problem)
        low, high = low + c.tau_min, high + c.tau_max
    else:
        low, high = max(low, c.tau_min), min(high, c.tau_max)
    return replace(c, actuated=True, tau_min=low, tau_max=high)
