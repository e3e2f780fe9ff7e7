"""Direct dependencies of FMU outputs, which hosts use to sort and solve systems.

An output depends on an input directly if its value at the end of a step changes with the input,
however short the step is. Positions of a plant have no direct dependencies, since forces change
them through the velocity. Forces of a controller depend on all inputs of its tick. At the start,
outputs depend on the parameters and inputs that the initialization uses.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from addin_sdfusion.robot import Muscle, Robot
from addin_sdfusion.robot.model.coupling import followers
from addin_sdfusion.robot.model.laws.law import evaluate
from addin_sdfusion.robot.model.muscle_laws import law_of, law_parameters, states_of

from .groups import Groups, all_ports
from .muscles import (
    FORCE,
    command_signals,
    driven_muscles,
    friction_muscles,
    ideal_muscles,
    modelled_muscles,
    muscles_with_tension,
    state_order,
)
from .port import muscle_signals
from .ports import LIMITS_DROPPED, SOLVE_TIME

Names = frozenset[str]

_NONE: Names = frozenset()
_NOWHERE: frozenset[int] = frozenset()
_COMMAND, _LENGTH, _RATE = "u", "l", "v"


@dataclass(frozen=True, slots=True)
class Dependencies:
    """Dependencies of each output of a model, by name."""

    direct: Mapping[str, Names]
    at_start: Mapping[str, Names]


def plant_dependencies(robot: Robot, groups: Groups) -> Dependencies:
    """Return the dependencies of a plant.

    Tensions without states depend directly on their command, contact forces on all inputs.
    """
    names = _names(groups)
    inputs = frozenset(names["commands"] + names["torques"] + names["loads"] + names["wrenches"])
    forces = [name for name in names["world"] if name.startswith("contact.")]
    direct, at_start = _no_dependencies(groups), _no_dependencies(groups)
    # A contact may begin within the step.
    direct.update(dict.fromkeys(forces, inputs))
    q, qd = names["q_start"], names["qd_start"]
    at_start.update({name: frozenset([start]) for name, start in zip(names["q"], q, strict=True)})
    at_start.update({name: frozenset([start]) for name, start in zip(names["qd"], qd, strict=True)})
    above = _coordinates_above(robot)
    crossed = [_path_coordinates(muscle, robot, above) for muscle in robot.muscles]
    for name, moving in zip(names["lengths"], crossed, strict=True):
        at_start[name] = _select(q, moving)
    links = [frame.link for frame in robot.task_frames for _ in frame.axes]
    for name, link in zip(names["tasks"], links, strict=True):
        at_start[name] = _select(q, above[link])
    for name in names["energies"]:
        at_start[name] = _energy_start(name, q, qd)
    pulls = muscle_signals(FORCE, robot)
    commands = dict(zip(driven_muscles(robot), command_signals(robot), strict=True))
    commands |= {k: pulls[k] for k in ideal_muscles(robot)}
    reported = muscles_with_tension(robot, groups)
    for name, k, signal in _muscle_outputs(robot, names, reported):
        muscle, command = robot.muscles[k], commands.get(k)
        arguments = {
            _COMMAND: frozenset() if command is None else frozenset([command]),
            _LENGTH: _select(q, _law_coordinates(muscle, crossed[k], above)),
            _RATE: _select(q, crossed[k]) | _select(qd, crossed[k]),
        }
        at_start[name] = _NONE.union(*(arguments[key] for key in _start_arguments(muscle, signal)))
        if _has_direct_command(muscle):
            direct[name] = arguments[_COMMAND]
    tensions = dict(zip(reported, names["tensions"], strict=True))
    for name, k in zip(names["far_tensions"], friction_muscles(robot), strict=True):
        same = tensions.get(k)  # at the start, friction has no direction yet
        direct[name] = frozenset([pulls[k]]) if same is None else direct[same]
        at_start[name] = frozenset([pulls[k]]) if same is None else at_start[same]
    return Dependencies(direct, at_start)


def controller_dependencies(
    robot: Robot, groups: Groups, unused: Sequence[str], *, delayed: bool
) -> Dependencies:
    """Return the dependencies of a controller.

    Outputs depend on all inputs of the tick. Delayed forces have no direct dependencies.

    Args:
        unused: Prefixes of reference names that the control law does not use, such as `qdd_d`.
        delayed: Whether the forces act one tick later.
    """
    names = _names(groups)
    followed = [name for name in names["reference"] if name.partition(".")[0] not in unused]
    read = [*names["q"], *names["qd"], *followed, *names["loads"], *names["states"]]
    read += [*names["estimated_loads"], *names["valid"], *names["bounds"], *names["reached"]]
    tuned = [name for prefix in ("kp", "kd", "f_min", "f_max") for name in names[prefix]]
    tick = frozenset([*read, *tuned])
    direct, at_start = _no_dependencies(groups), _no_dependencies(groups)
    reports = [name for name in names["report"] if name != SOLVE_TIME]
    now = [
        *names["slack"],
        *reports,
        *names["reaction"],
        *([] if delayed else names["forces"] + names["commands"]),
    ]
    direct.update(dict.fromkeys(now, tick))
    if LIMITS_DROPPED in direct:  # tasks have lower priority than joint limits
        irrelevant = frozenset(names["reference"] + names["kp"] + names["kd"])
        direct[LIMITS_DROPPED] = tick - irrelevant
    if delayed:
        direct.update(_inverse_law_dependencies(robot, names))
    m = len(robot.muscles)
    bounds = list(zip(names["forces"], names["f_min"], names["f_max"], strict=True))
    if not modelled_muscles(robot):
        at_start.update({force: frozenset([low]) for force, low, _ in bounds[:m]})
    # The start torque is the torque within the limits that is nearest to zero.
    at_start.update({torque: frozenset([low, high]) for torque, low, high in bounds[m:]})
    return Dependencies(direct, at_start)


def reference_dependencies(groups: Groups) -> Dependencies:
    """Return the dependencies of a reference, which depends on time only."""
    return Dependencies(_no_dependencies(groups), _no_dependencies(groups))


def sampled_dependencies(
    groups: Groups, *, delayed: bool = False, at_start: Mapping[str, str] = {}
) -> Dependencies:
    """Return the dependencies of sensors or an estimator: each output depends on all inputs.

    Args:
        groups: Variables of the model.
        delayed: Whether outputs are delayed.
        at_start: Group of parameters that each group of outputs equals at the start.
    """
    inputs = frozenset(port.name for port in all_ports(groups) if port.causality == "input")
    names, direct = _names(groups), _no_dependencies(groups)
    begin = dict(direct)
    for output, start in at_start.items():
        pairs = zip(names[output], names[start], strict=True)
        begin |= {name: frozenset([parameter]) for name, parameter in pairs}
    return Dependencies(direct if delayed else dict.fromkeys(direct, inputs), begin)


def hardware_dependencies(groups: Groups) -> Dependencies:
    """Return the dependencies of hardware: only tensions may change within an exchange."""
    names = _names(groups)
    direct = _no_dependencies(groups)
    if names["measured_tensions"]:
        commands = [*names["commands"], *names["torques"]]
        pairs = zip(names["measured_tensions"], commands, strict=True)
        direct.update({tension: frozenset([force]) for tension, force in pairs})
    return Dependencies(direct, _no_dependencies(groups))


def _names(groups: Groups) -> dict[str, list[str]]:
    return {name: [port.name for port in ports] for name, ports in groups.items()}


def _no_dependencies(groups: Groups) -> dict[str, Names]:
    return {port.name: _NONE for port in all_ports(groups) if port.causality == "output"}


def _select(names: Sequence[str], places: Iterable[int]) -> Names:
    return frozenset(names[place] for place in places)


def _coordinates_above(robot: Robot) -> dict[str, frozenset[int]]:
    """Return the indices of the coordinates that move each link."""
    above: dict[str, frozenset[int]] = {link.name: frozenset() for link in robot.links}
    moved_by = _moved_by(robot)
    for joint in robot.joints:
        in_joint = frozenset[int]().union(*(moved_by[c.name] for c in joint.coordinates))
        above[joint.child] = above.get(joint.parent, frozenset()).union(in_joint)
    return above


def _moved_by(robot: Robot) -> dict[str, frozenset[int]]:
    """Return the indices of the coordinates q that each coordinate depends on, by its name."""
    indices = {c.name: frozenset[int]() for c in robot.all_coordinates}
    indices |= {c.name: frozenset([k]) for k, c in enumerate(robot.coordinates)}
    for c in followers(robot):
        indices[c.name] = frozenset[int]().union(*(indices[term.coordinate] for term in c.coupling))
    return indices


def _path_coordinates(
    muscle: Muscle, robot: Robot, above: Mapping[str, frozenset[int]]
) -> frozenset[int]:
    """Return the indices of the coordinates that change the path of a muscle."""
    links = {surface.name: surface.link for surface in robot.wrap_surfaces}
    on = [point.link for point in muscle.via_points]
    on += [links[wrap.surface] for wrap in muscle.wraps]
    moved = [above.get(link, frozenset()) for link in on]
    coordinates = [point.when.coordinate for point in muscle.via_points if point.when is not None]
    coordinates += [move.coordinate for point in muscle.via_points for move in point.moves]
    coordinates += [term.coordinate for term in muscle.terms]
    moved_by = _moved_by(robot)
    explicit = _NOWHERE.union(*(moved_by[name] for name in coordinates))
    if robot.driven_joints:  # one coordinate may move both ends by different functions
        return explicit.union(*moved)
    return frozenset().union(*moved) - frozenset.intersection(*moved or [_NOWHERE]) | explicit


def _law_coordinates(
    muscle: Muscle, crossed: frozenset[int], above: Mapping[str, frozenset[int]]
) -> frozenset[int]:
    """Return the coordinates that the tension of a muscle law depends on.

    With sag, the tension also depends on the orientation of the cable.
    """
    if not law_of(muscle.model).sags:
        return crossed
    return crossed.union(*(above.get(point.link, _NOWHERE) for point in muscle.via_points))


def _energy_start(name: str, q: Sequence[str], qd: Sequence[str]) -> Names:
    if name.startswith("work."):
        return _NONE
    return frozenset(q if name == "energy.potential" else [*q, *qd])


def _muscle_outputs(
    robot: Robot, names: Mapping[str, Sequence[str]], reported: Sequence[int]
) -> list[tuple[str, int, str]]:
    """Return the outputs of muscles: name, index of the muscle, kind."""
    tensions = zip(names["tensions"], reported, strict=True)
    of_state = [(k, s.name) for k, m in enumerate(robot.muscles) for s in states_of(m.model)]
    states = zip(names["states"], (of_state[i] for i in state_order(robot)), strict=True)
    return [
        *((name, k, "tension") for name, k in tensions),
        *((name, k, state) for name, (k, state) in states),
    ]


def _start_arguments(muscle: Muscle, signal: str) -> str:
    """Return the letters of the arguments (u, l, v) of a muscle's output at the start."""
    law, values = law_of(muscle.model), law_parameters(muscle.model)
    letters = {state.name: state.at_start for state in law.states}.get(signal, law.at_start)
    is_damped = not law.damped or evaluate(law.damped, values)
    return letters if is_damped else letters.replace(_RATE, "")


def _has_direct_command(muscle: Muscle) -> bool:
    """Return whether a muscle's outputs depend on its command without delay."""
    law = law_of(muscle.model)
    if law.command is None or not law.states:
        return law.command is not None
    return bool(law.at_once and evaluate(law.at_once, law_parameters(muscle.model)))


def _inverse_law_dependencies(robot: Robot, names: Mapping[str, Sequence[str]]) -> dict[str, Names]:
    """Return the dependencies of commands that inverse laws compute from the last tick's forces."""
    above = _coordinates_above(robot)
    kinds = [k for k, muscle in enumerate(robot.muscles) for _ in states_of(muscle.model)]
    owner = dict(zip(names["states"], (kinds[i] for i in state_order(robot)), strict=True))
    dependencies = {}
    for name, k in zip(names["commands"], driven_muscles(robot), strict=True):
        muscle = robot.muscles[k]
        crossed = _law_coordinates(muscle, _path_coordinates(muscle, robot, above), above)
        states = frozenset(state for state, index in owner.items() if index == k)
        dependencies[name] = _select(names["q"], crossed) | _select(names["qd"], crossed) | states
    return dependencies
