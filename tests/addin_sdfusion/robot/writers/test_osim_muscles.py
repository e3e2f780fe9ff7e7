"""Hill-type muscles and ligaments have equal forces in OpenSim and in this simulation."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, Bench, slider

from addin_sdfusion.robot import check, read_robot
from addin_sdfusion.robot.formats.opensim.capabilities import osim_losses
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.model.muscle_laws import law_parameters

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # of its SWIG wrapper
    opensim = pytest.importorskip("opensim", reason="needs the extra opensim, which is for tests")

opensim.Logger.setLevelString("Error")

SHAPE = {"pennation_at_optimal": 0.2, "max_contraction_velocity": 8.0, "tendon_strain": 0.04}
ELASTIC = HILL | SHAPE | {"elastic_tendon": 1.0}


def ours_model(parameters):
    return slider(("hill_schutte1993", parameters)).muscles[0].model


def _opened(kind, parameters, folder):
    (file,) = write_osim(slider((kind, parameters)), folder, "robot")
    model = opensim.Model(str(file))
    state = model.initSystem()
    return model, state, model.getForceSet().get(0), model.getCoordinateSet().get(0)


@pytest.mark.parametrize("kind", ["hill_degroote2016", "hill_millard2012", "hill_thelen2003"])
@pytest.mark.parametrize("parameters", [HILL | SHAPE, ELASTIC])
def test_hill_muscles_have_equal_forces_in_opensim(kind, parameters, tmp_path):
    if kind == "hill_thelen2003":
        parameters = ELASTIC
    extra = {"hill_millard2012": {"isometric_slope": 4.0, "tendon_stiffness": 45.0}}
    parameters = parameters | extra.get(kind, {"passive_fibre_strain": 0.5})
    model, state, force, slide = _opened(kind, parameters, tmp_path)
    theirs = opensim.Muscle.safeDownCast(force)
    ours = Bench((kind, parameters))
    assert [f.code for f in osim_losses(ours.robot) if "law" in f.code] == []
    for length in (0.28, 0.3, 0.33):
        for activation in (0.1, 0.8):
            slide.setValue(state, length)
            theirs.setActivation(state, activation)
            if parameters.get("elastic_tendon"):
                model.realizePosition(state)
                theirs.computeEquilibrium(state)
            model.realizeDynamics(state)
            expected = theirs.getTendonForce(state)
            assert ours.start(length, activation) == pytest.approx(expected, rel=1e-6)


def test_schutte_muscle_has_equal_forces_and_is_restored(tmp_path):
    kind = "hill_schutte1993"
    times = {"activation_time_constant": 0.012, "deactivation_time_constant": 0.07}
    shape = {"pennation_at_optimal": 0.2, "fibre_damping": 0.05, "elastic_tendon": 1.0}
    parameters = HILL | shape | times
    model, state, force, slide = _opened(kind, parameters, tmp_path)
    (file,) = tmp_path.glob("*.osim")
    (muscle,) = read_robot(file).muscles
    assert law_parameters(muscle.model) == pytest.approx(law_parameters(ours_model(parameters)))
    ours, name = Bench((kind, parameters)), "/forceset/m0/"
    compared = 0
    for length, fibre in ((0.3, 0.09), (0.305, 0.1), (0.303, 0.11), (0.29, 0.085)):
        for activation, excitation in ((0.1, 0.6), (0.9, 0.2)):
            state = model.initSystem()
            slide.setValue(state, length, False)
            model.setStateVariableValue(state, f"{name}activation", activation)
            model.setStateVariableValue(state, f"{name}fiber_length", fibre)
            model.realizeVelocity(state)
            model.setControls(state, opensim.Vector(1, excitation))
            model.realizeAcceleration(state)
            theirs = opensim.Muscle.safeDownCast(force).getActuation(state)
            states = [activation, fibre]
            found = ours.tension(length, 0.0, excitation, states)
            assert found == pytest.approx(theirs, rel=1e-9, abs=1e-9)
            rates = ours.state_rates(length, 0.0, excitation, states)
            expected = [
                model.getStateVariableDerivativeValue(state, f"{name}{what}")
                for what in ("activation", "fiber_length")
            ]
            np.testing.assert_allclose(rates, expected, rtol=1e-7)
            compared += theirs > 0.0
    assert compared > 4


def test_ignored_fibre_damping_in_opensim_is_reported(tmp_path):
    """OpenSim's elastic De Groote muscle ignores it; here it slows the fibre."""
    kind, speeds = "hill_degroote2016", []
    for damping in (0.0, 0.1):
        parameters = ELASTIC | {"fibre_damping": damping}
        model, state, force, slide = _opened(kind, parameters, tmp_path)
        theirs, ours = opensim.Muscle.safeDownCast(force), Bench((kind, parameters))
        slide.setValue(state, 0.3)
        theirs.setActivation(state, 0.5)
        kT = np.log(6.0) / SHAPE["tendon_strain"]
        tension = 0.2 * np.exp(kT * 0.02) - 0.2  # for a tendon strain of 2 %
        model.setStateVariableValue(state, "/forceset/m0/normalized_tendon_force", tension)
        model.realizeAcceleration(state)
        fibre = theirs.getFiberLength(state)
        rate = ours.state_rates(0.3, 0.0, 0.5, [0.5, fibre])[1]
        speeds.append((theirs.getFiberVelocity(state), rate))
        found = [
            f.message for f in osim_losses(ours.robot) if f.code == "fibre-damping-passed-over"
        ]
        assert len(found) == bool(damping)
    (undamped, ours_undamped), (passed_over, ours_damped) = speeds
    assert undamped == pytest.approx(ours_undamped, rel=1e-9)
    assert passed_over == undamped
    assert abs(ours_damped) < 0.95 * abs(undamped)


def test_ligaments_have_equal_forces_in_opensim(tmp_path):
    parameters = {"linear_stiffness": 800.0, "slack_length": 0.25, "damping_coefficient": 0.5}
    kind = "ligament_blankevoort1991"
    model, state, force, slide = _opened(kind, parameters, tmp_path)
    theirs = opensim.Blankevoort1991Ligament.safeDownCast(force)
    ours = Bench((kind, parameters))
    for length in (0.24, 0.251, 0.26, 0.3):
        for speed in (-0.5, 0.5):
            slide.setValue(state, length)
            slide.setSpeedValue(state, speed)
            model.realizeDynamics(state)
            found = ours.tension(length, speed, 0.0)
            assert found == pytest.approx(theirs.getTotalForce(state), rel=1e-9, abs=1e-12)


def test_changed_parameters_in_opensim_are_reported():
    robot = slider(
        ("hill_thelen2003", HILL | {"minimum_activation": 0.0}),
        ("hill_millard2012", HILL | {"active_minimum": 0.2}),
        ("mckibben", {"thread_length": 0.3, "turns": 2.0}),
    )
    assert not [finding for finding in check(robot) if finding.is_error]
    reported = {f.subject.name: f for f in osim_losses(robot) if f.subject.kind == "muscle"}
    assert "elastic_tendon 1" in reported["m0"].message
    assert "minimum_activation 0.01" in reported["m0"].message
    assert "active_minimum 0" in reported["m1"].message
    assert reported["m2"].code == "cable-model-left-out"


def test_written_robot_is_simulated_in_opensim(tmp_path):
    """A robot with all muscle laws opens and is integrated."""
    robot = slider(
        ("hill_degroote2016", HILL),
        ("hill_millard2012", ELASTIC),
        ("hill_thelen2003", ELASTIC),
        ("elastic_cable", {"stiffness": 100.0}),
    )
    (file,) = write_osim(robot, tmp_path, "robot")
    model = opensim.Model(str(file))
    state = model.initSystem()
    model.getCoordinateSet().get(0).setValue(state, 0.31)
    model.equilibrateMuscles(state)
    manager = opensim.Manager(model, state)
    state = manager.integrate(0.01)
    assert np.isfinite(model.getCoordinateSet().get(0).getValue(state))
