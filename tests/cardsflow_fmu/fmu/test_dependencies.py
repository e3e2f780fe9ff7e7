"""Model structure of FMUs: declared dependencies agree with the effects of changed variables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from support.fmu.dependencies import (
    Probe,
    declared,
    observed_at_start,
    observed_at_tick,
    observed_direct,
    undeclared,
    unobserved,
)
from support.robots.muscle_bench import SOUND
from support.robots.robots import EXAMPLES
from support.run_modes import COMPUTE

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build

PLANAR = EXAMPLES / "planar_2r"


def laws(*models: Mapping[str, Any] | str) -> dict[str, Any]:
    """Return the two-link arm with one muscle law per cable."""
    return {f"muscles.cable_{k}.model": model for k, model in enumerate(models, 1)}


def law(kind: str, **more: float) -> dict[str, Any]:
    return {"kind": kind, **SOUND[kind], **more}


HILL = {"optimal_fibre_length": 0.45, "tendon_slack_length": 0.45, "max_isometric_force": 300.0}
LONG = {"optimal_fibre_length": 1.1, "tendon_slack_length": 1.2, "max_isometric_force": 300.0}
PASSIVE = {f"muscles.cable_{k}.{end}": 0.0 for k in (3, 4) for end in ("f_min", "f_max")}
PNEUMATIC = {"thread_length": 0.6, "turns": 3.0}
MOTOR = {"robot.joints.joint_1.motor": True, "robot.joints.joint_1.effort": 20.0}
PLANTS: dict[str, tuple[str, dict[str, Any]]] = {
    "ideal": ("planar_2r", {}),
    "quick": (
        "planar_2r",
        laws(
            law("elastic_cable", stiffness=400.0),
            law("elastic_cable", damping=0.0),
            law("mckibben", pressure_time_constant=0.0, **PNEUMATIC),
            law("mckibben", pressure_time_constant=0.05, **PNEUMATIC),
        ),
    ),
    "muscles": (
        "planar_2r",
        laws(
            law("hill_degroote2016", **HILL),
            law("hill_millard2012", **LONG, elastic_tendon=1.0),
            law("passive_spring"),
            law("ligament_blankevoort1991", linear_stiffness=40.0, slack_length=0.5),
        )
        | PASSIVE,
    ),
    "thelen": ("planar_2r", laws("ideal", law("hill_thelen2003", **LONG), "ideal", "ideal")),
    "motors": (
        "planar_2r",
        laws(*[{"kind": "series_elastic_motor", "rest_length": 0.3}] * 2, "ideal", "ideal"),
    ),
    "roboy": ("roboy_left_arm", {"plant.wrenches": ["upper_arm_left"]}),
    "hill_arm": ("hill_arm", {}),
    "pneumatic": ("pneumatic_elbow", {}),
    "joint_motors": ("planar_2r", MOTOR),
    "contacts": ("pick_up", {}),
}
TAUT = {"": 0.4, "m": 0.1, "V": 4.0, "Pa": 2e4}
KINDS = [(case, native) for case in PLANTS for native in (True, False) if case != "contacts"]
KINDS.append(("contacts", False))


def experiment_of(case: str) -> Experiment:
    example, settings = PLANTS[case]
    return Experiment.load(EXAMPLES / example, {"run.duration": 0.1, **settings})


@contextmanager
def probe_of(file: Path, folder: Path, base: Mapping[str, float]) -> Iterator[Probe]:
    probe = Probe(file, folder, base)
    yield probe
    probe.close()


def base_state(experiment: Experiment) -> dict[str, float]:
    """Return a generic state: moving joints away from their start positions, and taut muscles."""
    rng = np.random.default_rng(7)
    base = {}
    for k, coordinate in enumerate(experiment.plant_robot.coordinates):
        q = experiment.start.q[k]
        low, high = max(coordinate.lower, q - 0.5), min(coordinate.upper, q + 1.0)
        base[f"q_start.{coordinate.name}"] = q + 0.1 * (0.5 * (low + high) - q)
        base[f"qd_start.{coordinate.name}"] = float(rng.uniform(0.1, 0.4))
    ports = PlantModel.table(experiment)
    base |= {p.name: TAUT[p.unit] for p in ports if p.name[:2] == "u." and p.unit in TAUT}
    return base


def checked(case: str, native: bool, folder: Path, fmi: Any = "2.0") -> None:
    experiment = experiment_of(case)
    file = build(experiment, folder, fmi=fmi, arrays=False, compute=COMPUTE[native])["plant"]
    with probe_of(file, folder / "unpacked", base_state(experiment)) as probe:
        at_once, seen = declared(file, at_start=False), observed_direct(probe)
        assert undeclared(at_once, seen) == {}
        if case != "contacts":  # bodies without contact have no contact force
            assert unobserved(at_once, seen) == {}
        at_start = declared(file, at_start=True)
        seen = observed_at_start(probe, probe.names("input", "parameter"))
        assert undeclared(at_start, seen) == {}
        left = unobserved(at_start, seen)
        # all coordinates; rotations of the complete robot change no length
        assert {name for name in left if "energy" not in name and "momentum" not in name} == set()


@pytest.mark.cases(7)
@pytest.mark.slow
@pytest.mark.parametrize(("case", "native"), KINDS)
def test_dependencies_of_a_plant(case: str, native: bool, tmp_path: Path) -> None:
    checked(case, native, tmp_path)


@pytest.mark.slow
def test_dependencies_of_a_plant_in_fmi_3(tmp_path: Path) -> None:
    checked("quick", True, tmp_path, "3.0")


@pytest.mark.slow
def test_positions_depend_on_no_input(tmp_path: Path) -> None:
    """Therefore hosts find no algebraic loop between a plant and its controller."""
    for case in ("ideal", "muscles"):
        file = build(experiment_of(case), tmp_path / case, compute="c")["plant"]
        at_once = declared(file, at_start=False)
        assert {knowns for name, knowns in at_once.items() if name[:2] in ("q.", "qd")} == {
            frozenset()
        }


DELAY = {"controller.delay": 1}
CONTROLLERS: dict[str, tuple[str, dict[str, Any]]] = {
    "joint_space": ("planar_2r", {}),
    "force_position": ("planar_2r", {"controller.type": "force_position"}),
    "delayed": ("planar_2r", DELAY | {"controller.predict": False}),
    "predicted": ("planar_2r", DELAY | {"controller.type": "force_position"}),
    "operational": ("roboy_left_arm", {}),
    "reactive": ("roboy_left_arm", {"controller.type": "reactive_qp"}),
    "joint_motors": ("planar_2r", MOTOR),
    "muscles": ("hill_arm", {}),
    "late_muscles": ("pneumatic_elbow", DELAY),
}
TORQUES = {"controller.kp": 40.0, "controller.kd": 5.0}
for _name in ("torque_position", "lyapunov"):
    CONTROLLERS[_name] = ("planar_2r", TORQUES | {"controller.type": _name})
IN_C = ("joint_space", "joint_motors", "delayed", "operational", "muscles", "late_muscles")
KINDS_OF_CONTROLLERS = [
    (case, native) for case in CONTROLLERS for native in (True, False) if case in IN_C or not native
]


@pytest.mark.cases(4)
@pytest.mark.slow
@pytest.mark.parametrize(("case", "native"), KINDS_OF_CONTROLLERS)
def test_dependencies_of_a_controller(case: str, native: bool, tmp_path: Path) -> None:
    """Tested at a feasible and at an infeasible tick, so that the slack changes too."""
    example, settings = CONTROLLERS[case]
    experiment = Experiment.load(EXAMPLES / example, {"run.duration": 0.1, **settings})
    file = build(experiment, tmp_path, fmi="3.0", arrays=False, compute=COMPUTE[native])[
        "controller"
    ]
    at_once = declared(file, at_start=False)
    assert at_once.pop(SOLVE_TIME) == frozenset()
    tuned = ("kp.", "kd.", "f_min.", "f_max.", "tau_min.", "tau_max.")
    seen: dict[str, frozenset[str]] = dict.fromkeys(at_once, frozenset())
    for k, far in enumerate((0.02, 1.0, 30.0)):
        base = random_state(experiment, file, far)
        with probe_of(file, tmp_path / str(k), base) as probe:
            period = experiment.controller.period
            scales = (0.1, 3.0, 300.0, 1e5) if far < 30 else (0.3, 3.0)
            found = observed_at_tick(probe, period, probe.names("input"), scales)
            tunables = [n for n in probe.names("parameter") if n.startswith(tuned)]
            # a limit has an effect only on muscles that reach it
            assert undeclared(at_once, observed_at_tick(probe, period, tunables, (0.1,))) == {}
            seen = {name: seen[name] | found[name] for name in seen}
            if k == 0:
                at_start = declared(file, at_start=True)
                shown = observed_at_start(probe, probe.names("input", "parameter"))
                assert undeclared(at_start, shown) == {}
                assert unobserved(at_start, shown) == {}
    assert undeclared(at_once, seen) == {}
    inputs = {n: frozenset(k for k in of if not k.startswith(tuned)) for n, of in at_once.items()}
    if case == "reactive":  # its tasks have lower priority: only joint limits can be infeasible
        inputs["infeasible"] = inputs["limits_dropped"]
    if case == "muscles":  # most of them are at a limit in a tick
        unseen = set().union(*inputs.values()) - set().union(*seen.values())
        assert unseen <= {"w.hand.fy"}  # the arm moves in the other two directions
    else:
        assert unobserved(inputs, seen) == {}


def random_state(experiment: Experiment, file: Path, far: float) -> dict[str, float]:
    """Return the start state with errors up to `far`, and loads on all axes."""
    rng = np.random.default_rng(3)
    base = {}
    q = dict(zip((c.name for c in experiment.robot.coordinates), experiment.start.q, strict=True))
    for variable in fmpy.read_model_description(str(file)).modelVariables:
        head, _, tail = variable.name.partition(".")
        if variable.causality != "input":
            continue
        error = float(rng.uniform(0.5, 1.0)) * far
        if head == "q":
            base[variable.name] = q[tail]
        elif head in ("q_d", "y_d"):
            base[variable.name] = q.get(tail, 0.0) + error
        elif head in ("qd", "qd_d", "yd_d", "qdd_d", "ydd_d", "w"):
            base[variable.name] = error
        elif head == "activation":
            base[variable.name] = 0.2
        elif head == "pressure":
            base[variable.name] = 1e5
    return base


@pytest.mark.slow
def test_a_reference_depends_on_time_only(tmp_path: Path) -> None:
    for native in (True, False):
        file = build(experiment_of("ideal"), tmp_path / str(native), compute=COMPUTE[native])[
            "reference"
        ]
        for at_start in (True, False):
            assert set(declared(file, at_start=at_start).values()) == {frozenset()}


@pytest.mark.slow
def test_arrays_have_the_dependencies_of_their_elements(tmp_path: Path) -> None:
    """FMI 3.0 with arrays declares the same dependencies as with scalars."""
    experiment = experiment_of("muscles")
    both = [build(experiment, tmp_path / str(n), fmi="3.0", arrays=n, compute="c") for n in (0, 1)]
    for name in both[0]:
        for at_start in (True, False):
            scalars, arrays = (declared(files[name], at_start=at_start) for files in both)
            expected: dict[str, set[str]] = {}
            for output, knowns in scalars.items():
                heads = {known if known in arrays else known.split(".")[0] for known in knowns}
                key = output if output in arrays else output.split(".")[0]
                expected.setdefault(key, set()).update(heads)
            assert arrays == {key: frozenset(value) for key, value in expected.items()}


@pytest.mark.slow
def test_derivatives_at_the_start_agree_with_declared_dependencies(tmp_path: Path) -> None:
    """Derivatives are zero without a declared dependency, and nonzero with a declared one."""
    experiment = experiment_of("quick")
    file = build(experiment, tmp_path, compute="c")["plant"]
    at_start = declared(file, at_start=True)
    with probe_of(file, tmp_path / "unpacked", base_state(experiment)) as probe:
        probe.at_start()
        host, outputs = probe.host, probe.names("output")
        references = [host.references[name] for name in outputs]
        knowns = [name for name in probe.names("input", "parameter") if name != "step"]
        slopes = {
            known: host.slave.getDirectionalDerivative(references, [host.references[known]], [1.0])
            for known in knowns
        }
    for k, output in enumerate(outputs):
        shown = {known for known in knowns if abs(slopes[known][k]) > 1e-9}
        assert shown == at_start[output], output


@pytest.mark.slow
def test_derivatives_over_a_step_agree_with_declared_dependencies(tmp_path: Path) -> None:
    experiment = experiment_of("quick")
    file = build(experiment, tmp_path, compute="c")["plant"]
    with probe_of(file, tmp_path / "unpacked", base_state(experiment)) as probe:
        probe.at_start()
        probe.host.slave.exitInitializationMode()
        for output, knowns in declared(file, at_start=False).items():
            for known in knowns:
                places = [probe.host.references[name] for name in (output, known)]
                (slope,) = probe.host.slave.getDirectionalDerivative(places[:1], places[1:], [1.0])
                assert slope != 0.0


@pytest.mark.slow
def test_plant_and_controller_form_no_algebraic_loop(tmp_path: Path) -> None:
    """The search follows connections and declared dependencies, like a host."""
    for case, (name, settings) in PLANTS.items():
        if (
            case == "quick"
        ):  # a pressure without delay that the controller reads is an algebraic loop
            continue
        experiment = Experiment.load(EXAMPLES / name, {"run.duration": 0.1, **settings})
        files = build(experiment, tmp_path / case)
        assert not has_loop(files)


def has_loop(files: Mapping[str, Path]) -> bool:
    """Return whether the dependencies contain a loop; signals with equal names are connected."""
    through: dict[str, set[str]] = {}
    for role in ("plant", "controller", "reference"):
        for output, knowns in declared(files[role], at_start=False).items():
            # names identify signals: no plant outputs f., and no controller outputs q.
            through.setdefault(output, set()).update(knowns)
    done: set[str] = set()

    def reaches_itself(signal: str, path: frozenset[str]) -> bool:
        if signal in path:
            return True
        if signal in done:
            return False
        found = any(reaches_itself(known, path | {signal}) for known in through.get(signal, ()))
        done.add(signal)
        return found

    return any(reaches_itself(signal, frozenset()) for signal in through)


@pytest.mark.slow
def test_outputs_of_hardware_depend_on_no_input_except_tensions(tmp_path: Path) -> None:
    """Only tensions may change with the forces within an exchange."""
    file = build(experiment_of("ideal"), tmp_path)["hardware"]
    at_once = declared(file, at_start=False)
    expected = {name: frozenset[str]() for name in at_once}
    expected |= {f"tension.cable_{k}": frozenset([f"f.cable_{k}"]) for k in range(1, 5)}
    assert at_once == expected
    assert set(declared(file, at_start=True).values()) == {frozenset()}
