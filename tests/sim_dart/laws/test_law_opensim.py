"""Hill-type muscles compared with OpenSim. This requires the extra `opensim`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, Bench

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # of its SWIG wrapper
    opensim = pytest.importorskip("opensim", reason="needs the extra opensim, which is for tests")


CLASSES = {
    "hill_degroote2016": "DeGrooteFregly2016Muscle",
    "hill_millard2012": "Millard2012EquilibriumMuscle",
    "hill_thelen2003": "Thelen2003Muscle",
}
NAMES = {
    "max_isometric_force": "max_isometric_force",
    "optimal_fibre_length": "optimal_fiber_length",
    "tendon_slack_length": "tendon_slack_length",
    "pennation_at_optimal": "pennation_angle_at_optimal",
    "max_contraction_velocity": "max_contraction_velocity",
    "activation_time_constant": "activation_time_constant",
    "deactivation_time_constant": "deactivation_time_constant",
    "minimum_activation": "minimum_activation",
    "fibre_damping": "fiber_damping",
    "active_width_scale": "active_force_width_scale",
    "passive_shape": "KshapePassive",
    "active_shape": "KshapeActive",
    "concentric_shape": "Af",
    "eccentric_force": "Flen",
    "linear_from": "fv_linear_extrap_threshold",
    "maximum_pennation": "maximum_pennation_angle",
}
STRAINS = {
    "hill_degroote2016": (
        "tendon_strain_at_one_norm_force",
        "passive_fiber_strain_at_one_norm_force",
    ),
    "hill_thelen2003": ("FmaxTendonStrain", "FmaxMuscleStrain"),
}
OTHER = {
    "max_isometric_force": 640.0,
    "optimal_fibre_length": 0.13,
    "tendon_slack_length": 0.17,
    "pennation_at_optimal": 0.35,
    "max_contraction_velocity": 8.0,
}
CASES = {
    "hill_degroote2016": [
        {},
        {"fibre_damping": 0.02, "active_width_scale": 1.3},
        {"tendon_strain": 0.035, "passive_fibre_strain": 0.5},
    ],
    "hill_millard2012": [{}, {"fibre_damping": 0.0}, {"maximum_pennation": 1.2}],
    "hill_thelen2003": [
        {},
        {"tendon_strain": 0.033, "passive_fibre_strain": 0.5, "eccentric_force": 1.8},
        {"concentric_shape": 0.3, "active_shape": 0.5, "passive_shape": 4.0, "linear_from": 0.9},
    ],
}
EVERY = [(kind, extra) for kind, extras in CASES.items() for extra in extras]


class Muscle(NamedTuple):
    """Muscle between the ground and a sliding body in OpenSim."""

    model: Any
    state: Any
    muscle: Any
    slide: Any

    def at(self, length: float, speed: float, activation: float) -> None:
        self.slide.setValue(self.state, length, False)
        self.slide.setSpeedValue(self.state, speed)
        self.muscle.setActivation(self.state, activation)

    def realized(self) -> Any:
        self.model.realizeDynamics(self.state)
        return self.muscle


def _opensim(kind: str, parameters: Mapping[str, float], *, rigid: bool) -> Muscle:
    opensim.Logger.setLevelString("off")
    made = getattr(opensim, CLASSES[kind])()
    made.setName("m")
    made.set_ignore_tendon_compliance(rigid)
    for name, value in parameters.items():
        if name in NAMES:
            getattr(made, f"set_{NAMES[name]}")(value)
        elif kind in STRAINS:
            getattr(made, f"set_{STRAINS[kind][name != 'tendon_strain']}")(value)
    model = opensim.Model()
    body = opensim.Body("body", 1.0, opensim.Vec3(0), opensim.Inertia(1))
    model.addBody(body)
    joint = opensim.SliderJoint("joint", model.getGround(), body)
    joint.updCoordinate().setRangeMax(10.0)
    model.addJoint(joint)
    made.addNewPathPoint("begin", model.getGround(), opensim.Vec3(0))
    made.addNewPathPoint("end", body, opensim.Vec3(0))
    model.addForce(made)
    state = model.initSystem()
    force = model.getForceSet().get(0)
    muscle = getattr(opensim, CLASSES[kind]).safeDownCast(force)
    return Muscle(model, state, muscle, model.getCoordinateSet().get(0))


@pytest.mark.parametrize("geometry", [HILL, OTHER], ids=["plain", "pennate"])
@pytest.mark.parametrize(
    ("kind", "extra"), [case for case in EVERY if case[0] != "hill_thelen2003"]
)
def test_rigid_tendons_equal_opensim(
    kind: str, extra: dict[str, float], geometry: dict[str, float]
) -> None:
    """Compare all paths longer than the tendon. Negative forces are replaced by 0."""
    theirs = _opensim(kind, geometry | extra, rigid=True)
    ours = Bench((kind, geometry | extra))
    for length in np.linspace(geometry["tendon_slack_length"] + 0.003, 0.42, 24):
        for speed in (-1.4, -0.6, -0.1, 0.0, 0.1, 0.7, 1.5):
            for activation in (0.01, 0.2, 1.0):
                theirs.at(length, speed, activation)
                expected = max(theirs.realized().getTendonForce(theirs.state), 0.0)
                found = ours.tension(length, speed, 0.0, [activation])
                assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_flat_passive_curve_equals_opensims_muscle_without_passive_force() -> None:
    theirs = _opensim("hill_degroote2016", HILL, rigid=True)
    theirs.muscle.set_ignore_passive_fiber_force(True)
    ours = Bench(("hill_degroote2016", HILL | {"passive_fibre_strain": 1e9}))
    for length in np.linspace(HILL["tendon_slack_length"] + 0.003, 0.42, 24):
        theirs.at(length, 0.1, 0.2)
        expected = max(theirs.realized().getTendonForce(theirs.state), 0.0)
        found = ours.tension(length, 0.1, 0.0, [0.2])
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("geometry", [HILL, OTHER], ids=["plain", "pennate"])
@pytest.mark.parametrize(("kind", "extra"), EVERY)
def test_equilibria_of_elastic_tendons(
    kind: str, extra: dict[str, float], geometry: dict[str, float]
) -> None:
    """Compare to 1e-6. OpenSim stops at a fibre velocity below 1e-8 m/s."""
    theirs = _opensim(kind, geometry | extra, rigid=False)
    ours = Bench((kind, geometry | extra | {"elastic_tendon": 1.0}))
    for length in np.linspace(0.27, 0.37, 11):
        for activation in (0.02, 0.3, 1.0):
            theirs.at(length, 0.0, activation)
            theirs.model.realizePosition(theirs.state)
            theirs.muscle.computeEquilibrium(theirs.state)
            expected = theirs.realized().getTendonForce(theirs.state)
            found = ours.start(length, activation)
            assert found == pytest.approx(expected, rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("geometry", [HILL, OTHER], ids=["plain", "pennate"])
@pytest.mark.parametrize(
    ("kind", "extra"), [case for case in EVERY if case[0] != "hill_degroote2016"]
)
def test_fibre_velocities_equal_opensim(
    kind: str, extra: dict[str, float], geometry: dict[str, float]
) -> None:
    """Compare tendon force and fibre velocity outside of equilibrium."""
    theirs = _opensim(kind, geometry | extra, rigid=False)
    ours = Bench((kind, geometry | extra | {"elastic_tendon": 1.0}))
    along = geometry["optimal_fibre_length"] * np.linspace(0.6, 1.3, 8)
    for fibre in along:
        for stretch in (-0.01, 0.005, 0.02, 0.035, 0.05):
            length = geometry["tendon_slack_length"] * (1.0 + stretch) + fibre
            for activation in (0.05, 0.4, 1.0):
                theirs.at(length, 0.0, activation)
                theirs.muscle.setFiberLength(theirs.state, fibre)
                muscle = theirs.realized()
                force = ours.tension(length, 0.0, activation, [activation, fibre])
                rate = ours.state_rates(length, 0.0, activation, [activation, fibre])[1]
                expected = muscle.getFiberVelocity(theirs.state)
                assert force == pytest.approx(
                    muscle.getTendonForce(theirs.state), rel=1e-9, abs=1e-9
                )
                assert rate == pytest.approx(expected, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(("kind", "extra"), EVERY)
def test_activation_equals_opensim(kind: str, extra: dict[str, float]) -> None:
    theirs, ours = _opensim(kind, HILL | extra, rigid=False), Bench((kind, HILL | extra))
    for activation in (0.01, 0.05, 0.3, 0.6, 1.0):
        for excitation in (0.0, 0.05, 0.3, 0.55, 1.0):
            theirs.at(0.3, 0.0, activation)
            theirs.model.realizeVelocity(theirs.state)
            controls = theirs.model.updControls(theirs.state)
            theirs.muscle.setControls(opensim.Vector(1, excitation), controls)
            theirs.model.setControls(theirs.state, controls)
            theirs.model.realizeAcceleration(theirs.state)
            expected = theirs.muscle.getStateVariableDerivativeValue(theirs.state, "activation")
            found = ours.state_rates(0.3, 0.0, excitation, [activation])[0]
            assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_activation_is_clipped_to_its_range() -> None:
    model = opensim.MuscleFirstOrderActivationDynamicModel()
    model.finalizeFromProperties()
    ours = Bench(("hill_millard2012", HILL))
    for activation in (-0.2, 0.0, 0.005, 0.01, 1.0, 1.2):
        for excitation in (0.0, 0.004, 0.5, 1.0):
            found = ours.state_rates(0.3, 0.0, excitation, [activation])[0]
            expected = model.calcDerivative(activation, excitation)
            assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


SHAPES = [
    ("ActiveForceLengthCurve", "active_force_length", (0.5, 0.8, 1.7, 0.7, 0.2),
     ("active_shortest", "active_transition", "active_longest", "active_shallow_slope",
      "active_minimum")),
    ("ForceVelocityCurve", "force_velocity", (0.1, 0.3, 4.0, 0.05, 0.2, 1.6, 0.3, 0.5),
     ("concentric_slope_at_vmax", "concentric_slope_near_vmax", "isometric_slope",
      "eccentric_slope_at_vmax", "eccentric_slope_near_vmax", "eccentric_force",
      "concentric_curviness", "eccentric_curviness")),
    ("FiberForceLengthCurve", "passive_force_length", (0.1, 0.6, 0.3, 5.0, 0.4),
     ("passive_zero_strain", "passive_fibre_strain", "passive_stiffness_low",
      "passive_stiffness", "passive_curviness")),
    ("FiberForceLengthCurve", "passive_force_length", (-0.1, 0.5, 0.2, 4.0, 0.75),
     ("passive_zero_strain", "passive_fibre_strain", "passive_stiffness_low",
      "passive_stiffness", "passive_curviness")),
    ("TendonForceLengthCurve", "tendon_force_length", (0.04, 40.0, 0.5, 0.8),
     ("tendon_strain", "tendon_stiffness", "tendon_toe_force", "tendon_curviness")),
]  # fmt: skip


@pytest.mark.parametrize(("theirs", "ours", "values", "names"), SHAPES)
def test_millard_curves_with_other_parameters(
    theirs: str, ours: Any, values: tuple[float, ...], names: tuple[str, ...]
) -> None:
    curve = getattr(opensim, theirs)(*values)
    curve.ensureCurveUpToDate()
    bench = Bench(("hill_millard2012", HILL | dict(zip(names, values, strict=True))))
    x = np.linspace(0.98, 1.08, 60) if "tendon" in ours else np.linspace(-1.4, 2.0, 171)
    np.testing.assert_allclose(
        bench.curve(ours, x), [curve.calcValue(float(p)) for p in x], rtol=1e-9, atol=1e-10
    )
    np.testing.assert_allclose(
        bench.curve(ours, x, slope=True),
        [curve.calcDerivative(float(p), 1) for p in x],
        rtol=1e-8,
        atol=1e-8,
    )


@pytest.mark.parametrize("tendon_strain", [0.033, 0.06])
def test_millard_strains_determine_stiffness(tendon_strain: float) -> None:
    curve = opensim.TendonForceLengthCurve(tendon_strain)
    curve.ensureCurveUpToDate()
    bench = Bench(("hill_millard2012", HILL | {"tendon_strain": tendon_strain}))
    x = np.linspace(0.99, 1.1, 60)
    np.testing.assert_allclose(
        bench.curve("tendon_force_length", x),
        [curve.calcValue(float(p)) for p in x],
        rtol=1e-9,
        atol=1e-10,
    )


def test_ligaments_equal_opensim() -> None:
    """Check slack ligaments, both ends of the toe region, and other toe and damping parameters."""
    for extra in ({}, {"damping_coefficient": 0.0}, {"transition_strain": 0.03}):
        values = {"linear_stiffness": 730.0, "slack_length": 0.11} | extra
        made = opensim.Blankevoort1991Ligament()
        made.setName("m")
        for name, value in values.items():
            getattr(made, f"set_{name}")(value)
        model = opensim.Model()
        body = opensim.Body("body", 1.0, opensim.Vec3(0), opensim.Inertia(1))
        model.addBody(body)
        joint = opensim.SliderJoint("joint", model.getGround(), body)
        joint.updCoordinate().setRangeMax(10.0)
        model.addJoint(joint)
        path = made.upd_GeometryPath() if hasattr(made, "upd_GeometryPath") else made.updPath()
        path = opensim.GeometryPath.safeDownCast(path)
        path.appendNewPathPoint("begin", model.getGround(), opensim.Vec3(0))
        path.appendNewPathPoint("end", body, opensim.Vec3(0))
        model.addForce(made)
        state = model.initSystem()
        ligament = opensim.Blankevoort1991Ligament.safeDownCast(model.getForceSet().get(0))
        slide = model.getCoordinateSet().get(0)
        ours = Bench(("ligament_blankevoort1991", values))
        for strain in (-0.3, -1e-9, 0.0, 1e-9, 0.01, 0.03, 0.0599999, 0.06, 0.0600001, 0.5, 3.0):
            for speed in (-2.0, -1e-3, 0.0, 1e-3, 2.0):
                length = 0.11 * (1.0 + strain)
                slide.setValue(state, length, False)
                slide.setSpeedValue(state, speed)
                model.realizeDynamics(state)
                expected = ligament.getTotalForce(state)
                found = ours.tension(length, speed, 0.0)
                assert found == pytest.approx(expected, rel=1e-9, abs=1e-9), (strain, speed)
