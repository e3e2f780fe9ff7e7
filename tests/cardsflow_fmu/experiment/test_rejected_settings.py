"""Rejected settings: each row contains changed settings and the expected message."""

from __future__ import annotations

from typing import Any

import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu import Experiment
from sim_dart.plant.settings import MAX_SUBSTEPS

Row = tuple[dict[str, Any], str]
INF, NAN = float("inf"), float("nan")
BLIND = {"hardware.has_positions": False}
MCKIBBEN = {"kind": "mckibben", "turns": 3.0, "pressure_time_constant": 0.02}
MOTOR = {"robot.joints.joint_2.motor": True}
BALL = {"name": "ball", "shape": "sphere", "radius": 0.05, "mass": 0.2, "position": [3, 0, 1]}
MESH = {"name": "die", "shape": "mesh", "mass": 0.2, "file": "no.stl"}
CABLE = "robot.muscles.cable_1"
UNIT = {"link": "upper_arm_left"}
THELEN = {"kind": "hill_thelen2003"}
JOINT_SPACE = {"type": "joint_space", "kp": 2000.0, "kd": 90.0, "period": 0.005}


def model(**changes: Any) -> dict[str, Any]:
    return {"muscles": {"biceps": changes}}


def length_drift(**changes: object) -> dict[str, Any]:
    """Return a failure of the emulated device with changes."""
    failure = {"kind": "length_drift", "part": "motor1", "time": 1.0} | changes
    return {"hardware.emulator.failures": [failure]}


def blend_reference(**last: float) -> dict[str, Any]:
    """Return a reference of two points with changes of the last point."""
    points = [{"time": 0, "y": [0.5, -0.45, 0.4]}, {"time": 1, "y": [0.5, -0.45, 0.5]} | last]
    return {"reference": {"spline": "parabolic_blend", "points": points}}


def world_settings(**refused: Any) -> dict[str, Any]:
    return {"world": refused}


def waypoints(**second: Any) -> dict[str, Any]:
    """Return a reference of points without a spline."""
    first = {"time": 0.0, "q": [0.0, 0.0]}
    return {"reference": {"points": [first, {"time": 1.0} | second]}}


def motors(**settings: Any) -> dict[str, Any]:
    return {"hardware.motors": settings}


def cable(model: Any) -> dict[str, Any]:
    return {"muscles.cable_1.model": model}


PLANAR_2R: list[Row] = [
    ({"controller.kpp": 2000.0}, "controller.kpp: no key 'kpp'; did you mean 'kp'"),
    (
        {"controller.kd": {"joint_1": 1, "joint_3": 1}},
        "controller.kd.joint_3: no coordinate 'joint_3'",
    ),
    ({"controller.kd": "90"}, "controller.kd: must be a number, not '90'"),
    ({"controller.kd": True}, "controller.kd: must be a number, not True"),
    ({"controller.kp": INF}, "controller.kp: must be a finite number"),
    ({"controller.kp": -1}, "controller.kp: must be above 0"),
    ({"controller.kp": [1.0]}, "controller.kp: must have 2 values"),
    ({"controller.muscle_horizon": -1.0}, "controller.muscle_horizon: must not be negative"),
    *(({"controller.norm": norm}, "controller.norm: ") for norm in (0, 2.5, 9, "inf", "two")),
    ({"controller.period": 0.0015}, "controller.period: 0.0015 s is not a whole"),
    ({"controller.period": 0.0005}, "controller.period: 0.0005 s is not a whole"),
    ({"controller.solver": "dapq"}, "controller.solver: no QP solver 'dapq'; did you mean 'daqp'"),
    (
        {"controller.type": "joint"},
        "controller.type: no controller type 'joint'; did you mean 'joint_space'",
    ),
    ({"controller.pretension": 1.1e9}, "controller.pretension"),
    ({"controller.pretension": [0.0, 1e308, 0.0, 0.0]}, "controller.pretension"),
    ({"controller.muscle_horizon": 1e308}, "controller.muscle_horizon"),
    ({"controller.space": "joint"}, "controller.space: is only for custom laws"),
    ({"fmus.motor": "a.fmu"}, "fmus.motor: no key 'motor'"),
    ({"fmus.plant": 3}, "fmus.plant: must be a table"),
    ({"fmus.plant": "p" * 400}, "ppp does not exist"),
    ({"hardware": 3}, "hardware: must be a table"),
    ({"hardware.approach": 0.00015}, "hardware.approach: 0.00015 s is not a whole multiple"),
    ({"hardware.emulator.delay": -1.0}, "hardware.emulator.delay: must not be negative: -1.0"),
    ({"hardware.emulator.duplicate": NAN}, "duplicate: must be a finite number, not nan"),
    (
        {"hardware.emulator.jitter": INF},
        "jitter: must be a finite number, not inf",
    ),
    ({"hardware.emulator.joint_counts": 0.0}, "joint_counts: must be above 0, not 0.0"),
    ({"hardware.emulator.length_counts": NAN}, "length_counts: must be a finite number, not nan"),
    ({"hardware.emulator.loss": 1.5}, "hardware.emulator.loss: must be from 0 to 1, not 1.5"),
    ({"hardware.emulator.loss": 0.1, "hardware.link": "loopback:"}, "does not support faults"),
    ({"hardware.emulator.lost": 1.0}, "did you mean 'loss'"),
    ({"hardware.emulator.motor_lag": -1.0}, "must not be negative"),
    ({"hardware.emulator.noise": -1.0}, "hardware.emulator.noise: must not be negative: -1.0"),
    ({"hardware.emulator.noise": INF}, "hardware.emulator.noise: must be a finite number, not inf"),
    ({"hardware.emulator.outages": 1.0}, "must be a list"),
    ({"hardware.emulator.outages": [1.0]}, "must be a list of 2 numbers"),
    ({"hardware.emulator.outages": [[-1.0, 1.0]]}, "outages[0]: must begin at 0 s or later"),
    ({"hardware.emulator.outages": [[1.0, NAN]]}, "outages[0][1]: must be a finite number"),
    ({"hardware.emulator.reorder": -0.1}, "reorder: must be from 0 to 1, not -0.1"),
    ({"hardware.emulator.seed": -1}, "hardware.emulator.seed: must not be negative: -1"),
    ({"hardware.force_rate": 0.0}, "hardware.force_rate: must be above 0"),
    ({"hardware.force_rate": [1.0]}, "hardware.force_rate: must have 4 values"),
    (BLIND | {"hardware.has_lengths": False}, "requires has_lengths and has_tensions"),
    (BLIND | motors(command="length", stiffness=1.0), "require joint velocities"),
    (BLIND | {"hardware.use": True}, "false requires an [estimator] with feedback"),
    (
        BLIND | {"hardware.use": True, "estimator": {"encoder_noise": {"joint_1": 1e-3}}},
        "false excludes encoders; remove estimator.encoder_noise",
    ),
    (
        {"hardware.has_tensions": False, "hardware.max_tension": 9.0},
        "requires hardware.has_tensions = true",
    ),
    ({"hardware.lnk": "x"}, "hardware.lnk: no key 'lnk'; did you mean 'link'"),
    ({"hardware.max_missed": -1}, "hardware.max_missed: must not be negative"),
    ({"hardware.max_missed": 1.5}, "hardware.max_missed: must be a whole number"),
    ({"hardware.max_missed": 1e308}, "hardware.max_missed: must be within 64 bits"),
    ({"hardware.max_missed": INF}, "hardware.max_missed: must be a finite number"),
    ({"hardware.key_file": "a\0b"}, "hardware.key_file: must be the path of a file"),
    ({"hardware.mode": "turbo"}, "hardware.mode: no mode 'turbo'"),
    (motors(command="thought"), "hardware.motors.command: no command 'thought'"),
    (motors(stiffness=3.0), "hardware.motors.stiffness: no key 'stiffness'"),
    (motors(command="length"), "hardware.motors.stiffness: missing"),
    (motors(command="length", stiffness=0.0), "hardware.motors.stiffness: must be above 0"),
    (
        motors(command="length", stiffness=1.0, damping=-1.0),
        "hardware.motors.damping: must not be negative",
    ),
    (
        motors(command="length", stiffness=1.0, offset="end"),
        "hardware.motors.offset: must be a number",
    ),
    ({"hardware.ramp_down": 60.0}, "hardware.ramp_down: must be at most 3"),
    ({"hardware.ramp_in": -1}, "hardware.ramp_in: must not be negative"),
    ({"hardware.scale": 0.0}, "hardware.scale: must be above 0"),
    ({"hardware.start_tolerance": -0.1}, "hardware.start_tolerance: must not be negative"),
    ({"hardware.max_tension": {"cable_9": 1.0}}, "no muscle 'cable_9'; did you mean 'cable_"),
    ({"hardware.use": 1}, "hardware.use: must be true or false"),
    ({"hardware.watchdog": 0}, "hardware.watchdog: must be above 0"),
    ({"hardware.watchdog": 0.001}, "hardware.watchdog: must be at least twice run.step"),
    (
        {"muscles.cabel_1.f_min": 1},
        "no muscle 'cabel_1'; did you mean 'cable_1'? (known: cable_1, cable_2",
    ),
    (
        {"muscles.cable_3.f_min": 200.0},
        "muscles.cable_3: f_min must be at most f_max, not 200.0 N with f_max 100.0 N",
    ),
    ({"muscles.cable_3.f_min": -1.0}, "muscles.cable_3.f_min: must not be negative"),
    (
        cable({"preset": "roboy_test_bench", "kind": "mckibben"}),
        "'roboy_test_bench' has the law 'series_elastic_motor', not 'mckibben'",
    ),
    (cable("hil"), "muscles.cable_1.model: no muscle model 'hil'"),
    (cable(3), "muscles.cable_1.model: must be a table"),
    (cable("mckibben"), "model.thread_length: missing; mckibben requires thread_length in m"),
    (cable({"kind": "mckibben", "turns": 2.0}), "muscles.cable_1.model.thread_length: missing"),
    (
        cable(MCKIBBEN | {"thread_length": -1.0}),
        "thread_length must be above 0 and at most 1000, not -1.0",
    ),
    (
        cable(MCKIBBEN | {"thread_lenght": 1.0}),
        "model.thread_lenght: no key 'thread_lenght'; did you mean 'thread_length'?",
    ),
    (cable(MCKIBBEN | {"thread_length": "long"}), "model.thread_length: must be a number"),
    ({"muscles.leg_*.f_max": 50.0}, "muscles.leg_*: no muscle matches; known: cable_1"),
    ({"muscles.cable_1.model": "hill_from_path", f"{CABLE}.f_max": INF}, "f_max"),
    ({"plant": 3}, "plant: must be a table, not 3"),
    ({"plant.energy": 1}, "plant.energy: must be true or false"),
    ({"plant.integrator": "rk5"}, "plant.integrator: no integrator 'rk5'"),
    ({"plant.step": 0.0003}, "run.step: 0.001 s is not a whole multiple of plant.step, 0.0003 s"),
    ({"plant.stpe": 1}, "plant.stpe: no key 'stpe'; did you mean 'step'"),
    ({"plant.substeps": 0}, "plant.substeps: must be at least 1"),
    ({"plant.substeps": MAX_SUBSTEPS + 1}, "plant.substeps: must be at most 1000000"),
    ({"plnt.step": 1}, "plnt: no key 'plnt'; did you mean 'plant'"),
    ({"plant.wrenches": "link_2"}, "plant.wrenches: must be a list of names"),
    ({"plant.wrenches": ["lnk_2"]}, "plant.wrenches: no link 'lnk_2'"),
    ({"plant.integrator": "rk4", "plant.engine": "dart"}, "plant.integrator: rk4 does not support"),
    (
        world_settings(friction=1.0) | {"plant.integrator": "rk4"},
        "rk4 does not support worlds with contacts",
    ),
    (
        {"reference.trajectory": "simple_motion"},
        "reference.trajectory: no trajectory 'simple_motion'; did you mean 'simple_joint_motion'",
    ),
    (waypoints(q={}), "points[1].q: missing"),
    (waypoints(q=[0.2, 0.1], qd=[1.0, 1.0]), "reference.points[1].qd: no key 'qd'"),
    ({"robot.cable_set": "basics"}, "robot.cable_set: no cable set 'basics'; did you mean 'basic'"),
    ({"robot.path": "robot/none_bodies.xml"}, "none_bodies.xml: "),
    ({"reference.file": "a\0b.csv"}, "reference.file: must be the path of a file"),
    (MOTOR | {"robot.joints.joint_2.motor": 1}, "motor"),
    (MOTOR | {"robot.joints.joint_2.effort": -1.0}, "negative"),
    (MOTOR | {"robot.joints.joint_2.effort": 0.0}, "has no torque"),
    (MOTOR | {"robot.joints.joint_2.effort": [1.0]}, "2 numbers"),
    (MOTOR | {"robot.joints.joint_2.effort": [2.0, 1.0]}, "above tau_max"),
    ({"robot.links.link_1": 3.0}, "must be a table"),
    ({"robot.links.link_1.inertia.mass": -1.0}, "mass"),
    ({"robot.links.link_1.inertia.mass": "heavy"}, "must be a number"),
    ({"robot.links.link_1.inertia.masss": 1.0}, "did you mean 'mass'"),
    ({"robot.linkz.link_1.inertia.mass": 1.0}, "did you mean 'links'"),
    ({"robot.muscles.cabel_1.f_max": 1.0}, "did you mean 'cable_1'"),
    ({"robot.muscles.leg_*.f_max": 50.0}, "robot.muscles.leg_*: no muscle matches; known: cable_1"),
    ({f"{CABLE}.name": "x"}, "no field 'name'"),
    ({f"{CABLE}.points": 1.0}, "such as points[0]"),
    ({f"{CABLE}.points[0].link": 3}, "must be a text"),
    ({f"{CABLE}.points[0].link": "nowhere"}, "nowhere"),
    ({f"{CABLE}.points[0].position": [0.0] * 2}, "list of 3 numbers"),
    ({f"{CABLE}.points[7].position": [0.0] * 3}, "2 elements"),
    ({f"{CABLE}.pulley": 3.0}, "cannot be changed"),
    ({"robots": []}, "cannot be used together with [robot]"),
    ({"run.duration": 1e12}, "run.duration: 1e+15 steps exceed the maximum of a run"),
    ({"run.duration": 8.0005}, "run.duration: 8.0005 s is not"),
    ({"run.step": 0}, "run.step: must be above 0"),
    ({"run.scheme": "gauss_seidel"}, "run.order: missing"),
    ({"run.scheme": "gauss_seidel", "run.order": ["plant"]}, "in any order"),
    ({"run.scheme": "strong"}, "run.scheme: no scheme 'strong'"),
    ({"run.format": "cvs"}, "run.format: no format 'cvs'; did you mean"),
    ({"run.order": ["plant"]}, "no key 'order'"),
    ({"run.output": "a\0b"}, "run.output: must be the path of a file"),
    (
        {"start.q": {"joint1": 0}},
        "start.q.joint1: no coordinate 'joint1'; did you mean 'joint_1'",
    ),
    ({"start.q": {"joint_1": NAN}}, "start.q.joint_1: must be a finite number"),
    ({"start.y": {"tip.x": 0.4}}, "start.y.tip.z: missing"),
    ({"start.q": {"joint_1": 4.0}}, "start.q.joint_1: must be within the joint limits"),
    (
        {"wiring.controler": {"q.joint_1": "plant.q.joint_1"}},
        "wiring.controler: no key 'controler'; did you mean 'controller'",
    ),
    ({"world": 3}, "world: must be a table"),
    (world_settings(contacts=["link_1"]), "no link or object that collides 'link_1'"),
    (world_settings(friction=-1.0), "world.friction: must not be negative: -1.0"),
    (world_settings(friction_law="prism"), "no friction law 'prism'"),
    (world_settings(groud=True), "world.groud: no key 'groud'; did you mean 'ground'"),
    (world_settings(ground={"hight": 0.1}), "did you mean 'height'"),
    (world_settings(ignore=[["a"]]), "world.ignore[0]: must be a list of 2 names"),
    (world_settings(links="mesh"), "did you mean 'meshes'"),
    (world_settings(objects=3), "world.objects: must be a list of tables"),
    (world_settings(objects=[BALL, BALL]), "the name 'ball' is already used"),
    (world_settings(objects=[BALL | {"colour": 1}]), "no key 'colour'"),
    (world_settings(objects=[BALL | {"mass": -1}]), "objects[0].mass: must not be negative: -1"),
    (world_settings(objects=[BALL | {"name": "link_1"}]), "'link_1' is already used"),
    (world_settings(objects=[BALL | {"radius": 0}]), "objects[0].radius: must be above"),
    (world_settings(objects=[BALL | {"shape": "bal"}]), "objects[0].shape: no shape"),
    (world_settings(objects=[MESH]), "no.stl does not exist"),
    (world_settings(sdf="none.world"), "none.world: cannot be read"),
    (
        world_settings(shapes=[{"link": "lnk_1", "shape": "sphere", "radius": 1}]),
        "did you mean 'link_1'",
    ),
]
HILL_ARM: list[Row] = [
    (model(model=THELEN | {"max_isometric_force": "F0"}), '"f_max"'),
    (model(model=THELEN | {"optimal_fibre_length": "path / 2"}), "0.6 path"),
    (model(model="hill_from_path", f_max=9.0, pose={"knee": 0.0}), "no coordinate 'knee'"),
]
ROBOY_LEFT_ARM: list[Row] = [
    ({"controller": JOINT_SPACE}, "controller.type: 'joint_space' cannot follow"),
    ({"controller.delay": 3}, "controller.delay: must be at most 1"),
    ({"controller.kp": 0.0}, "controller.kp: must be above 0"),
    ({"controller.kp": {"hnad": 1.0}}, "controller.kp.hnad: no task coordinate 'hnad'"),
    ({"controller.norm": 4}, "norm: requires a joint-space law; 'operational_space'"),
    ({"controller.period": 1e300}, "controller.period: 1e+303 steps exceed"),
    ({"controller.posture.kp": -1.0}, "controller.posture.kp: must not be negative"),
    ({"controller.predict": 1}, "controller.predict: must be true or false"),
    ({"controller.priorities": 0.5}, "controller.priorities: must be an integer of at least 1"),
    ({"controller.task_weights": -1.0}, "controller.task_weights: must be positive, or 'exact'"),
    ({"disturbance": {"begin": 2.0, "end": 1.0}}, "disturbance.end: must be after begin"),
    ({"disturbance.force": {"foot": [0, 0, 1]}}, "disturbance.force.foot: no task frame"),
    ({"disturbance.known": True}, "disturbance.force: missing; set forces on hand"),
    ({"estimator.gate": 0.0}, "estimator.gate"),
    ({"estimator.type": "mhe"}, "estimator.type: no type 'mhe'"),
    ({"estimator.frames": 5}, 'estimator.frames: requires estimator.type = "horizon"'),
    ({"estimator.type": "horizon", "estimator.frames": 1}, "estimator.frames: must be at least 2"),
    (
        {"estimator.type": "horizon", "estimator.huber": -1.0},
        "estimator.huber: must not be negative",
    ),
    ({"estimator.length_noise": -1.0}, "estimator.length_noise"),
    ({"estimator.length_noise.motor99": 1e-3}, "no muscle 'motor99'"),
    ({"estimator.offset_drift": -1e-5}, "estimator.offset_drift: must not be negative"),
    ({"estimator.offset_drift.motor99": 1e-5}, "estimator.offset_drift.motor99: no muscle"),
    ({"estimator.offset_drift": "slow"}, "estimator.offset_drift: must be a number"),
    ({"estimator.start_offset_sd": [1e-3]}, "estimator.start_offset_sd: must have 11 values"),
    ({"estimator.start_offset_sd.motor1": True}, "estimator.start_offset_sd.motor1: must be a"),
    ({"estimator.sensors.delay": 0.0015}, "estimator.sensors.delay: 0.0015 s is not a whole"),
    ({"estimator.sensors.nothing": 1}, "estimator.sensors.nothing: no key 'nothing'"),
    ({"estimator.imus": [UNIT, UNIT]}, "rename one"),
    ({"estimator.imus": [{"link": "hand"}]}, "estimator.imus[0].link: no link 'hand'"),
    ({"plant.mass_scale": 0.0}, "plant.mass_scale: must be above 0"),
    (blend_reference(), "reference.points[1].blend_time: missing"),
    (blend_reference(blend_time=0.0), "reference.points[1].blend_time: must be above 0"),
    (
        blend_reference(blend_time=0.5),
        "reference.points[1].blend_time: must be less than half the time",
    ),
    ({"reference.approach.duration": 0.0}, "reference.approach.duration: must be above 0"),
    ({"reference.flower.axes": [[1, 0, 0], [1, 0, 0]]}, "reference.flower.axes: must be two"),
    ({"reference.flower.petals": 0}, "reference.flower.petals: must be at least 1"),
    ({"reference.flower.radius": -0.1}, "reference.flower.radius: must be above 0"),
    ({"reference.flower.radius": 3.0}, "reference: no configuration reaches hand.x 3.45"),
    ({"faults": {}}, "faults: requires an estimator; add [estimator], or remove [faults]"),
    (
        {"estimator": {}, "faults.false_alarms_per_hour": 0},
        "faults.false_alarms_per_hour: must be above 0",
    ),
    ({"estimator": {}, "faults.alarms": 1}, "faults.alarms: no key 'alarms'"),
    ({"estimator": {}, "faults.ramp": -1}, "faults.ramp: must not be negative"),
    ({"estimator": {}, "faults.motor_lag": -1e-3}, "faults.motor_lag: must not be negative"),
    ({"estimator": {}, "faults.length_error": -1e-4}, "faults.length_error: must not be negative"),
    ({"estimator": {}, "faults.tension_error": "5 %"}, "faults.tension_error: must be a number"),
    ({"estimator": {}, "faults": []}, "faults: must be a table"),
    (length_drift(), "failures[0].value: missing; it is required for kind 'length_drift'"),
    (length_drift(value=1e-5, other="motor2"), "failures[0].other: is unused for kind"),
    (length_drift(value=1e-5, time=-1.0), "failures[0].time: must not be negative"),
    (length_drift(value=INF), "failures[0].value: must be"),
    (length_drift(kind="length_drfit"), "failures[0].kind: no kind 'length_drfit'; did you mean"),
    ({"estimator": {}, "faults.react": "maybe"}, "faults.react: must be true or false"),
    (
        {"estimator": {}, "faults.tension_noise": {"motor99": 1.0}},
        "faults.tension_noise.motor99: no muscle 'motor99'",
    ),
    (
        {"estimator.sensors.delay": 0.5, "faults": {}},
        "estimator.sensors.delay: must be at most 60 steps",
    ),
    ({"robot.operational_space": "foot"}, "robot.operational_space: no operational space"),
    ({"start.y": [0.5, -0.45]}, "start.y: must have 3 values, one per task coordinate"),
    ({"start.y": [2.0, 0.0, 0.0]}, "start.y: "),
    ({"start.y": {"hand": {"x": 0.4}}}, "start.y.hand: must be a number, not a table; put names"),
]
ROWS = [
    pytest.param(example, *row, id=f"{example}-{row[1]}")
    for example, rows in (
        ("planar_2r", PLANAR_2R),
        ("bicycle", [({"start.y": [0.4]}, "start.y: the robot has no task coordinates; add")]),
        ("hill_arm", HILL_ARM),
        ("roboy_left_arm", ROBOY_LEFT_ARM),
    )
    for row in rows
]


@pytest.mark.parametrize(("example", "settings", "message"), ROWS)
def test_invalid_setting_is_one_line_with_file_and_key(
    example: str, settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(CardsflowError) as caught:
        Experiment.load(EXAMPLES / example, settings)
    line = str(caught.value)
    assert message in line
    assert "\n" not in line
    assert f"{EXAMPLES / example}" in line
