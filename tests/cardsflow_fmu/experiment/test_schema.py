"""JSON Schemas of the settings agree with the readers."""

from __future__ import annotations

import copy
import math
import tomllib
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import Any, get_args

import pytest
from jsonschema import Draft202012Validator
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError, UnknownNameError
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from cardsflow_fmu.cli.setup.init import schema
from cardsflow_fmu.experiment import scene
from cardsflow_fmu.experiment.config.table import Context
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.reader import experiment_settings
from cardsflow_fmu.experiment.settings import plant, world
from cardsflow_fmu.experiment.settings.world import SIZES
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion
from cardsflow_fmu.studies.definition.reader import read_study
from cardsflow_fmu.studies.definition.tables import StudyTables
from sim_dart.plant.settings import MAX_SUBSTEPS
from sim_dart.scene import FrictionLaw, LinkGeometry

EXPERIMENTS = sorted(file.parent for file in EXAMPLES.glob("*/experiment.toml"))
STUDIES = sorted((EXAMPLES / "design_study").glob("*.toml"))
EXPERIMENT, STUDY = schema("experiment"), schema("study")
Form = dict[str, Any]
VALIDATORS = {kind: Draft202012Validator(schema(kind)) for kind in ("experiment", "study")}
Path_ = tuple[str | int, ...]


def content(file: Path) -> dict[str, Any]:
    return tomllib.loads(file.read_text())


def errors(kind: str, data: dict[str, Any]) -> list[str]:
    return [error.message for error in VALIDATORS[kind].iter_errors(data)]


@pytest.mark.slow
@pytest.mark.parametrize("kind", VALIDATORS)
def test_schema_is_a_valid_json_schema(kind: str) -> None:
    Draft202012Validator.check_schema(schema(kind))


@pytest.mark.parametrize("folder", EXPERIMENTS, ids=lambda folder: folder.name)
def test_example_experiment_matches_the_schema(folder: Path) -> None:
    assert errors("experiment", content(folder / "experiment.toml")) == []


@pytest.mark.parametrize("folder", EXPERIMENTS, ids=lambda folder: folder.name)
def test_written_experiment_matches_the_schema(folder: Path) -> None:
    is_optimised = content(folder / "experiment.toml").get("reference", {}).get("type")
    load = load_for_motion if is_optimised == "optimised" else Experiment.load
    data = experiment_data(load(folder, {}))
    assert errors("experiment", data) == []


@pytest.mark.parametrize("file", STUDIES, ids=lambda file: file.name)
def test_example_study_matches_the_schema(file: Path) -> None:
    assert errors("study", content(file)) == []


def tables(form: Form, path: Path_ = ()) -> Iterator[Path_]:
    """Yield the paths of all tables with keys; `name` stands for any name, 0 for any index."""
    for own in form.get("anyOf", (form,)):
        if own.get("type") == "array":
            yield from tables(own.get("items", {}), (*path, 0))
        if own.get("type") != "object":
            continue
        more = own.get("additionalProperties")
        if more is False:
            yield path
            for key, inner in own["properties"].items():
                yield from tables(inner, (*path, key))
        elif isinstance(more, dict):
            yield from tables(more, (*path, "name"))


def with_key(data: dict[str, Any], path: Path_, key: str, value: Any) -> dict[str, Any]:
    """Return the data with an additional key in the table at a path; a missing table is created."""
    data = copy.deepcopy(data)
    place: Any = data
    for k, part in enumerate(path):
        empty: Any = [] if k + 1 < len(path) and isinstance(path[k + 1], int) else {}
        if isinstance(place, list):
            place.extend([] if place else [copy.deepcopy(empty)])
        elif not isinstance(place.get(part), type(empty)):
            place[part] = copy.deepcopy(empty)
        place = place[part]
    place[key] = value
    return data


def path_text(path: Path_) -> str:
    """Return a path as in messages."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def read_data(data: dict[str, Any], file: Path) -> None:
    """Read an experiment from data, as the experiment file of the planar arm."""
    Experiment(**experiment_settings(data, file))


@pytest.mark.parametrize("path", list(tables(EXPERIMENT)), ids=path_text)
def test_unknown_key_is_rejected_by_schema_and_reader(path: Path_) -> None:
    file = PLANAR_2R / "experiment.toml"
    data = with_key(content(file), path, "nonsense", 1.0)
    with pytest.raises(UnknownNameError, match="no key 'nonsense'") as caught:
        read_data(data, file)
    assert caught.value.key == f"{path_text(path)}.nonsense".lstrip(".")
    wrong = {
        "/".join(map(str, e.absolute_path)) for e in VALIDATORS["experiment"].iter_errors(data)
    }
    assert any("/".join(map(str, path)).startswith(place) for place in wrong)
    assert errors("experiment", data)


def test_message_quotes_the_begin_of_a_long_key() -> None:
    file = PLANAR_2R / "experiment.toml"
    with pytest.raises(UnknownNameError) as caught:
        read_data(with_key(content(file), ("controller",), "k" * 5000, 1.0), file)
    assert len(str(caught.value)) < 3000


@pytest.mark.parametrize("path", list(tables(STUDY)), ids=path_text)
def test_unknown_key_of_a_study_is_rejected_by_schema_and_reader(path: Path_) -> None:
    file = STUDIES[0]
    data = with_key(content(file), path, "nonsense", 1.0)
    with pytest.raises(UnknownNameError, match="no key 'nonsense'"):
        StudyTables.read(data, Context(file))
    assert errors("study", data)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("comput = 'c'\n", "comput: no key 'comput'; did you mean 'compute'"),
        ("[optimize]\nobjective = 'x'\n", "optimize: .*did you mean 'optimise'"),
        ("[[vary]]\npth = 'x'\n", r"vary\[0\].pth: no key 'pth'; did you mean 'path'"),
        ("[[vary]]\nunifrm = [0, 1]\n", r"vary\[0\].unifrm: .*did you mean 'uniform'"),
        ("[workspace]\npoint = 3\n", "workspace.point: .*did you mean 'points'"),
    ],
)
def test_unknown_key_of_a_study_has_a_suggestion(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "study.toml"
    file.write_text(f"experiment = {str(PLANAR_2R)!r}\n{text}")
    with pytest.raises(UnknownNameError, match=message):
        read_study(file)


# Other keys or tables that are required so that the reader checks a key.
BESIDE: dict[str, dict[str, Any]] = {
    "run.order": {"scheme": "gauss_seidel"},
    "start.seed": {"y": 1.0},
    "reference.points": {"spline": "linear"},
    "reference.name": {"spline": "linear", "points": []},
    "reference.spline": {"points": []},
    "reference.file": {"trajectory": "simple_joint_motion"},
}
INSIDE: dict[str, dict[str, Any]] = {
    "motion.parameters[0]": {"path": "robot.links.link_1.inertia.mass", "from": 0.05, "to": 0.3},
    "disturbance": {"force": {"hand": [0.0, 0.0, 1.0]}},
    "estimator.imus[0]": {"link": "link_1"},
    "hardware.emulator.failures[0]": {"kind": "broken", "part": "cable_1", "time": 0.0},
    "faults": {},
    "hardware.motors": {"command": "length", "stiffness": 5e3},
    "robots[0]": {"name": "arm", "path": "robot"},
    "motion.cost.tracking": {"file": "experiment.toml"},
    "motion.obstacles[0]": {"centre": [1.0, 0.0, 0.0], "radius": 0.1},
    "muscles.name.model": {"kind": "hill_degroote2016"},
    "world": {"ground": True},
    "world.objects[0]": {"name": "thing", "shape": "sphere", "radius": 0.1},
    "world.shapes[0]": {"link": "link_1", "shape": "sphere", "radius": 0.1},
}
OF_SHAPES: dict[str, dict[str, Any]] = {
    "length": {"shape": "capsule"},
    "size": {"shape": "box"},
    "file": {"shape": "mesh"},
    "scale": {"shape": "mesh", "file": "experiment.toml"},
}
OPERATIONAL = {"y", "seed", "flower", "approach", "posture", "disturbance", "yd", "ydd"} | {
    *("task_weights", "priorities", "acceleration_weights", "force_rate_weights"),
    "limit_bandwidth",
}
NOTHING_FITS: Any = [[{}]]


def leaves(form: Form, path: Path_ = ()) -> Iterator[tuple[Path_, str]]:
    """Yield every key of every table."""
    for place in tables(form, path):
        own: Form = form
        for part in place:
            own = inner(own, part)
        for table in own.get("anyOf", (own,)):
            for key in table.get("properties", {}):
                yield place, key


def inner(form: Form, part: str | int) -> Form:
    kind = "array" if isinstance(part, int) else "object"
    own = next(own for own in form.get("anyOf", (form,)) if own.get("type") == kind)
    if isinstance(part, int):
        return own["items"]
    return own.get("properties", {}).get(part) or own["additionalProperties"]


def is_free(place: Path_, key: str) -> bool:
    """Return whether the reader accepts any value for a key, or does not read its table."""
    return (not place and key in ("robots",)) or (place[:1] == ("fmus",) and len(place) > 1)


LAW_PARAMETERS = {own.name for law in MUSCLE_LAWS.values() for own in law.parameters}
LEAVES = [
    (place, key)
    for place, key in leaves(EXPERIMENT)
    if not is_free(place, key) and not (key in LAW_PARAMETERS and place[-1:] == ("model",))
]


@pytest.mark.slow
@pytest.mark.parametrize(("place", "key"), LEAVES, ids=lambda x: path_text(x) or "top")
def test_reader_checks_every_key_of_the_schema(place: Path_, key: str) -> None:
    operational = OPERATIONAL & {key, *map(str, place)}
    folder = EXAMPLES / ("roboy_left_arm" if operational else "planar_2r")
    file = folder / "experiment.toml"
    data = content(file)
    path = tuple("cable_1" if part == "name" else part for part in place)
    if place[:1] == ("robots",):
        del data["robot"]
    if place[:1] == ("reference",) and not operational:
        data["reference"] = {}
    around = BESIDE.get(path_text((*place, key))) or INSIDE.get(path_text(place), {})
    if place[:1] == ("world",):
        around = around | OF_SHAPES.get(key, {})
    if place[:1] == ("motion",):
        data["motion"] = {"duration": 1.0, "goals": [{"q": 0.0}]}
    if place == ("reference", "points", 0):
        begin: dict[str, Any] = {"time": 0.0, "y" if key.startswith("y") else "q": 0.0}
        begin.pop(key, None)
        spline = "parabolic_blend" if key == "blend_time" else "quintic"
        data["reference"] = {"spline": spline, "points": [begin, begin | {"time": 1.0}]}
        path = ("reference", "points", 1 if key == "blend_time" else 0)
    for k, v in around.items():
        data = with_key(data, path, k, v)
    data = with_key(data, path, key, NOTHING_FITS)
    with pytest.raises(InputError) as caught:
        read_data(data, file)
    expected = path_text((*path, key))
    assert (caught.value.key or "").startswith(expected), str(caught.value)
    assert errors("experiment", data)


VALUES: tuple[Any, ...] = ("x", "", -1, 0, 0.5, 2, True, [], [1.0], {}, {"x": 1.0}, None)


def mutated(data: Any, path: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    """Yield data with one changed value, except for numbers in lists."""
    for key, value in data.items():
        if isinstance(value, dict):
            yield from mutated(value, (*path, key))
        yield (*path, key), value


@pytest.mark.slow
@pytest.mark.parametrize("name", ["planar_2r", "hill_arm", "pick_up"])
def test_schema_accepts_all_that_the_reader_accepts(name: str) -> None:
    """An editor must not mark valid settings: values of all kinds are tested at all keys."""
    file = EXAMPLES / name / "experiment.toml"
    data = content(file)
    taken = refused = 0
    for path, _ in mutated(data):
        for value in VALUES:
            other = with_key(data, path[:-1], str(path[-1]), value)
            if not (wrong := errors("experiment", other)):
                continue
            refused += 1
            try:
                read_data(other, file)
            except InputError:
                continue
            taken += 1
            pytest.fail(f"{path_text(path)} = {value!r} is read, but: {wrong[0]}")
    assert refused > 100
    assert taken == 0


def test_names_in_settings_match_the_known_names() -> None:
    assert list(SIZES) == list(scene._SHAPES) == list(get_args(world.ShapeName))
    assert get_args(FrictionLaw) == get_args(world.FrictionLaw)
    assert get_args(LinkGeometry) == get_args(world.LinkGeometry)
    assert MAX_SUBSTEPS == plant.MAX_SUBSTEPS


def test_defaults_of_the_schema_change_nothing() -> None:
    """With all defaults of [plant], [run] and [controller] written, the experiment is the same."""
    plain = Experiment.load(PLANAR_2R, {})
    joint = {"ki", "observer", "delay", "predict", "muscle_horizon"}
    settings = {
        f"{name}.{key}": own["default"]
        for name in ("plant", "run", "controller")
        for key, own in EXPERIMENT["properties"][name]["properties"].items()
        if "default" in own and (name != "controller" or key in joint)
    }
    assert len(settings) > 10
    assert experiment_data(Experiment.load(PLANAR_2R, settings)) == experiment_data(plain)


def test_all_invalid_keys_and_values_of_a_file_are_reported_together() -> None:
    """One line per error with file and key; unknown keys first, without consequential errors."""
    wrong = {
        "run.step": "x",
        "controller.kp": {"joint_1": 1.0, "joint_2": "much"},
        "controller.periood": 0.01,
        "plant.substeps": 0.5,
        "worlld.ground": True,
        "hardware.emulator.loss": 2.0,
        "muscles.cable_1.model": "hil",
    }
    with pytest.raises(UnknownNameError) as caught:
        Experiment.load(PLANAR_2R, wrong)
    lines = str(caught.value).splitlines()
    assert [line.split(": ", 1)[1].split(" (known")[0] for line in lines] == [
        "controller.periood: no key 'periood'; did you mean 'period'?",
        "worlld: no key 'worlld'; did you mean 'world'?",
        "muscles.cable_1.model: no muscle model 'hil'; did you mean 'ideal'?",
        "controller.kp.joint_2: must be a number, not 'much'",
        "plant.substeps: must be a whole number, not 0.5",
        "run.step: must be a number, not 'x'",
        "hardware.emulator.loss: must be from 0 to 1, not 2.0",
    ]
    assert all(line.startswith(f"{PLANAR_2R}") for line in lines)


ODD: tuple[Any, ...] = (
    *(10**400, -(10**400), math.nan, math.inf, True, None, "", "\0", date(2026, 11, 22)),
    *([], [[]], {}, {"": {}}, [{}], [None], {"x": math.nan}, {"*": True}),
)


@pytest.mark.cases(65)
@pytest.mark.slow
@pytest.mark.parametrize(("place", "key"), LEAVES, ids=lambda x: path_text(x) or "top")
def test_odd_values_are_read_or_rejected_with_the_file(place: Path_, key: str) -> None:
    """Messages contain no traceback and no text of pydantic."""
    file = PLANAR_2R / "experiment.toml"
    path = tuple("cable_1" if part == "name" else part for part in place)
    for value in ODD:
        data = with_key(content(file), path, key, value)
        try:
            read_data(data, file)
        except InputError as error:
            for line in str(error).splitlines():
                assert "Input should" not in line, line
                assert str(PLANAR_2R) in line, line
