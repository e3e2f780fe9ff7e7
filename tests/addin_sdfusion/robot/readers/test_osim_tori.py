"""Tori of OpenSim: in the initial pose path lengths agree with OpenSim."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.oracles.opensim_model import opensim

from addin_sdfusion.robot import Vector3
from addin_sdfusion.robot.formats.read import read
from sim_dart import MusclePaths

pytestmark = [pytest.mark.interop, pytest.mark.native]


def torus_model(folder: Path, end: Vector3, initial: float) -> Path:
    """Return an arm on a hinge, with a muscle through a torus on the ground."""
    vector = opensim.Vec3
    model = opensim.Model()
    model.setName("ring")
    ground, arm = model.getGround(), opensim.Body("arm", 1.0, vector(0), opensim.Inertia(1, 1, 1))
    model.addBody(arm)
    hinge = opensim.PinJoint("hinge", ground, vector(0), vector(0), arm, vector(0), vector(0))
    hinge.updCoordinate().setName("q")
    hinge.updCoordinate().setDefaultValue(initial)
    model.addJoint(hinge)
    torus = opensim.WrapTorus()
    torus.setName("hole")
    for name, radius in (("inner_radius", 0.01), ("outer_radius", 0.03)):
        opensim.PropertyHelper.setValueDouble(radius, torus.updPropertyByName(name))
    torus.set_xyz_body_rotation(vector(1.4, 0.3, 0.2))
    torus.set_translation(vector(0.02, -0.03, 0.01))
    ground.addWrapObject(torus)
    muscle = opensim.Thelen2003Muscle("m", 100.0, 0.1, 0.05, 0.0)
    muscle.addNewPathPoint("a", ground, vector(0.05, 0.12, 0.02))
    muscle.addNewPathPoint("b", arm, vector(*end))
    muscle.updGeometryPath().addPathWrap(torus)
    model.addForce(muscle)
    model.finalizeConnections()
    model.printToXML(str(folder / "ring.osim"))
    return folder / "ring.osim"


@pytest.mark.parametrize(
    ("end", "initial", "expected"),
    [
        ((-0.09, -0.13, 0.03), 0.0, "torus-as-cylinder"),
        ((0.08, -0.13, 0.01), 0.2, "torus-as-cylinder"),
        ((0.03, -0.13, -0.09), -0.4, "torus-as-cylinder"),
        ((0.05, 0.2, 0.03), 0.0, "wrap-left-out"),
    ],
)
def test_path_through_a_torus_has_the_length_of_opensim(
    tmp_path: Path, end: Vector3, initial: float, expected: str
) -> None:
    file = torus_model(tmp_path, end, initial)
    reading = read(file)
    (found,) = [f for f in reading.findings if f.code in ("torus-as-cylinder", "wrap-left-out")]
    assert (found.code, found.line is not None) == (expected, True)
    model = opensim.Model(str(file))
    state = model.initSystem()
    path = opensim.GeometryPath.safeDownCast(model.getComponent("/forceset/m/path"))
    (length,) = MusclePaths(reading.require()).evaluate(np.array([initial])).lengths
    if expected == "wrap-left-out":  # OpenSim routes it half around the tube
        assert length == pytest.approx(math.dist((0.05, 0.12, 0.02), end), abs=1e-15)
    else:
        assert length == pytest.approx(path.getLength(state), abs=1e-6)
