"""Table of muscle laws and C core: equal definitions, and checks of parameters in the core."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from support.robots.muscle_bench import (
    BROKEN_RULES,
    HILL,
    SOUND,
    Bench,
    slider,
    values_outside_bounds,
)

from addin_sdfusion.robot import CableModel, CardsflowError, InputError
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from addin_sdfusion.robot.model.laws.hill import RULES as HILL_RULES
from addin_sdfusion.robot.model.laws.law import Parameter
from addin_sdfusion.robot.model.muscle_laws import (
    PRESETS,
    command_range,
    law_parameters,
    states_of,
)
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library, pack_blob

pytestmark = pytest.mark.native


@pytest.mark.parametrize("kind", SOUND)
def test_defaults_are_within_bounds_and_accepted_by_the_core(kind: str) -> None:
    for parameter in MUSCLE_LAWS[kind].parameters:
        if parameter.default is not None:
            assert parameter.allows(parameter.default)
        assert parameter.meaning
        assert parameter.unit
    Bench((kind, SOUND[kind]))


def test_every_law_has_a_source() -> None:
    assert all(law.source and law.meaning for law in MUSCLE_LAWS.values())


def _blob(**fields: object) -> bytes:
    """Return the blob of a slider with one De Groote muscle and changed numbers."""
    robot = slider(("hill_degroote2016", HILL))
    values = list(law_parameters(robot.muscles[0].model).values())
    whole = {"law_kind": [list(MUSCLE_LAWS).index("hill_degroote2016")], "law_parameter": values}
    changed = whole | fields
    counts = dict.fromkeys(_counts(), 0)
    counts |= {"dofs": 1, "frames": 1, "variables": 1, "muscles": 1, "points": 2, "robots": 1}
    counts["law_parameters"] = len(changed["law_parameter"])  # type: ignore[arg-type]
    tree = {
        "parent": [-1],
        "motion": [1],
        "coordinate": [0],
        "offset_rotation": np.eye(3),
        "offset_position": np.zeros(3),
        "axis": [1, 0, 0],
        "mass": [1],
        "mass_centre": np.zeros(3),
        "inertia": np.ones(6),
        "gravity": np.zeros(3),
        "muscle_points": [2],
        "muscle_bends": [0],
        "presliding": [1],
        "point_frame": [-1, 0],
        "point_position": np.zeros((2, 3)),
    }
    tree |= {
        key: [0]
        for key in [
            "damping",
            "friction",
            "stiffness",
            "rest",
            "armature",
            "lower",
            "upper",
            "variable_terms",
        ]
    }
    empty: dict[str, object] = {name: [] for name in _fields()}
    return pack_blob(counts, empty | tree | changed)  # type: ignore[arg-type]


def _counts() -> list[str]:
    lines = library().core_layout().decode().splitlines()
    return [line.split()[1] for line in lines if line.startswith("count")]


def _fields() -> list[str]:
    lines = library().core_layout().decode().splitlines()
    return [line.split()[1] for line in lines if line.split()[0] in ("real", "int32_t")]


def test_blob_with_invalid_law_is_rejected() -> None:
    Core(_blob())
    for kind in (-1, len(MUSCLE_LAWS), 2**31 - 1):
        with pytest.raises(CardsflowError, match=f"muscle 0: unknown muscle law {kind}"):
            Core(_blob(law_kind=[kind]))
    sound = list(law_parameters(CableModel("hill_degroote2016", tuple(HILL.items()))).values())
    for wrong in (sound[:-1], [*sound, 1.0], []):
        with pytest.raises(CardsflowError, match="parameters do not add up"):
            Core(_blob(law_parameter=wrong))


PARAMETERS = [(kind, p) for kind in SOUND for p in MUSCLE_LAWS[kind].parameters]


@pytest.mark.parametrize(("kind", "parameter"), PARAMETERS)
def test_core_rejects_every_parameter_out_of_bounds(kind: str, parameter: Parameter) -> None:
    for value in (math.nan, math.inf, -math.inf, *values_outside_bounds(parameter)):
        text = f"muscle 0: {kind}: {parameter.name} must be {re.escape(parameter.bounds)}$"
        with pytest.raises(CardsflowError, match=text):
            Core(compile_blob(slider((kind, SOUND[kind] | {parameter.name: value}))))


@pytest.mark.parametrize(("kind", "parameters", "what"), BROKEN_RULES)
def test_inconsistent_parameters_are_rejected(
    kind: str, parameters: dict[str, float], what: str
) -> None:
    with pytest.raises(CardsflowError, match=f"muscle 0: {kind}: {re.escape(what)} must hold"):
        Core(compile_blob(slider((kind, SOUND[kind] | parameters))))


def test_every_rule_has_a_test_case() -> None:
    rules = {(kind, own.condition) for kind in SOUND for own in MUSCLE_LAWS[kind].conditions}
    hill = {own.condition for own in HILL_RULES}  # shared rules; one law is sufficient
    broken = {(kind, what) for kind, _, what in BROKEN_RULES}
    assert {(kind, what) for kind, what in rules - broken if what not in hill} == set()
    assert hill <= {what for _, what in broken}
    assert broken <= rules


@pytest.mark.slow
def test_random_parameters_are_rejected_or_give_finite_tensions() -> None:
    rng = np.random.default_rng(11)
    refused = 0
    for _ in range(1500):
        kind = str(rng.choice([kind for kind in SOUND if MUSCLE_LAWS[kind].parameters]))
        values = dict(SOUND[kind])
        for parameter in rng.choice(MUSCLE_LAWS[kind].parameters, 2):
            values[parameter[0]] = float(rng.normal() * 10.0 ** rng.integers(-6, 6))
        try:
            bench = Bench((kind, values))
        except CardsflowError:
            refused += 1
            continue
        tensions = [bench.start(0.3, 0.5), bench.tension(0.3, 0.2, 1.0)]
        bench.advance(0.3, 0.2, 1.0, 1e-3)
        assert np.isfinite([*tensions, *bench.laws.states]).all(), (kind, values)
    assert 300 < refused < 1400


def test_ports_follow_from_the_laws() -> None:
    elastic = HILL | {"elastic_tendon": 1.0}
    bench = Bench(*((kind, SOUND[kind]) for kind in SOUND), ("hill_thelen2003", elastic))
    laws = bench.laws
    kinds = [*SOUND, "hill_thelen2003"]
    assert [kinds[i] for i in np.flatnonzero(laws.passive)] == [
        "passive_spring",
        "ligament_blankevoort1991",
        "path_spring",
        "tendon_spring",
    ]
    assert [kinds[i] for i in np.flatnonzero(~laws.modelled)] == ["ideal"]
    assert laws.state_names == (
        *(f"{name}.m3" for name in ("current", "spindle_speed", "spindle_angle")),
        "pressure.m4",
        *(f"activation.m{i}" for i in (5, 6, 7, 8)),
        "activation.m10",
        *(f"{name}.m{i}" for i in (13, 14) for name in ("drum_speed", "drum_angle")),
        "activation.m16",
        "fibre_length.m16",
    )
    units = ("A", "rad/s", "rad", "Pa", *"11111", "rad/s", "rad", "rad/s", "rad", "1", "m")
    assert laws.state_units == units
    units = ("N", "m", "", "V", "Pa", *"1111", "", "1", "", "", "N.m", "m", "m", "1")
    assert laws.command_units == units
    assert laws.command_low.tolist() == [0, 0, 0, -24, *[0] * 9, -2, 0, 0, 0]
    high = [math.inf, 1000, 0, 24, 6e5, 1, 1, 1, 1, 0, 1, 0, 0, 2, 1000, 1000, 1]
    assert laws.command_high.tolist() == high


def test_preset_accepts_other_parameters() -> None:
    preset = PRESETS["roboy_test_bench"]
    parameters = {**dict(preset.parameters), "max_voltage": 12.0}
    model = CableModel("series_elastic_motor", tuple(parameters.items()))
    assert preset.kind == model.kind
    assert law_parameters(model)["gear_ratio"] == 128.0
    assert command_range(model) == (-12.0, 12.0)
    assert [state.name for state in states_of(model)][-1] == "spindle_angle"
    with pytest.raises(InputError, match="'stiffness' is missing"):
        law_parameters(CableModel("elastic_cable"))


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_complete(name: str) -> None:
    given = {key for key, _ in PRESETS[name].parameters}
    law = MUSCLE_LAWS[PRESETS[name].kind]
    assert given | {"rest_length", "max_voltage"} == {p.name for p in law.parameters}


def test_invalid_input_is_named() -> None:
    bench = Bench(("mckibben", SOUND["mckibben"]), ("hill_thelen2003", HILL))
    bench.move(0.3)
    laws = bench.laws
    for call in (laws.start, lambda u: laws.drive([0.0], u)):
        with pytest.raises(InputError, match="command nan of muscle 'm1' is not finite"):
            call([0.0, math.nan])
        with pytest.raises(InputError, match="shape"):
            call([0.0])
    with pytest.raises(InputError, match="command inf of muscle 'm0'"):
        laws.advance([math.inf, 0.0], 1e-3)
    with pytest.raises(InputError, match="force nan of muscle 'm1'"):
        laws.invert([0.0, math.nan], 1e-3)
    with pytest.raises(InputError, match=r"state 'activation.m1' is not finite"):
        laws.set_states([0.0, math.nan])
    assert np.isnan(bench.curve("force_velocity", 0.0))


@pytest.mark.slow
def test_mutated_laws_are_rejected_or_can_be_computed() -> None:
    """Change arbitrary bytes. Reads stay within bounds and tensions are numbers."""
    rng = np.random.default_rng(2)
    elastic = HILL | {"elastic_tendon": 1.0}
    models = [*SOUND.items(), *((kind, elastic) for kind in SOUND if kind.startswith("hill"))]
    robot = slider(*models)
    sound, m = compile_blob(robot), len(models)
    refused = 0
    for _ in range(3000):
        blob = bytearray(sound)
        for _ in range(rng.integers(1, 4)):
            blob[rng.integers(len(blob) // 2, len(blob))] = rng.integers(256)
        try:
            core = Core(bytes(blob))
        except CardsflowError:
            refused += 1
            continue
        u, q, qd = np.full(m, 0.3).tobytes(), np.full(1, 0.3).tobytes(), np.ones(1).tobytes()
        core.move(core.handle, q)
        core.update_rates(core.handle, qd)
        core.start(core.handle, u)
        core.drive(core.handle, qd, u)
        core.advance(core.handle, u, 1e-3)
        core.update_law_rates(core.handle, u)
        core.reach(core.handle, 1e-3)
        core.invert(core.handle, u, 4e-3, 1e-3)
        assert np.isfinite(core.array("tensions", m)).all()
        assert np.isfinite(core.array("commands", m)).all()
    assert 500 < refused < 2900
