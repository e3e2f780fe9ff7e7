"""OpenSim's models: M, gravity and lengths are OpenSim's own; what is not read is said."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from support.oracles.moving_links import MovingLinks

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.function import Polynomial, derivatives
from addin_sdfusion.robot.model.tension_laws import law_parameters
from addin_sdfusion.robot.readers import read

MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="40000"><Model name="leg"><gravity>0 -9.8 0</gravity>
<BodySet><objects>
  <Body name="shank"><mass>2</mass><mass_center>0 -0.2 0</mass_center>
    <inertia>0.02 0.003 0.02 0 0 0</inertia>
    <WrapObjectSet><objects>
      <WrapCylinder name="heel"><xyz_body_rotation>0 0.5 0</xyz_body_rotation>
        <quadrant>x</quadrant><radius>0.02</radius><length>0.1</length></WrapCylinder>
    </objects></WrapObjectSet></Body>
  <Body name="patella"><mass>0.1</mass><mass_center>0 0 0</mass_center>
    <inertia>1e-4 1e-4 1e-4 0 0 0</inertia></Body>
</objects></BodySet>
<JointSet><objects>
  <PinJoint name="pat"><socket_parent_frame>/bodyset/shank</socket_parent_frame>
    <socket_child_frame>/bodyset/patella</socket_child_frame>
    <coordinates><Coordinate name="pat_angle"/></coordinates></PinJoint>
  <CustomJoint name="knee"><socket_parent_frame>thigh_frame</socket_parent_frame>
    <socket_child_frame>/bodyset/shank</socket_child_frame>
    <coordinates><Coordinate name="knee_angle"><default_value>0.3</default_value>
      <range>-2 0.2</range><clamped>true</clamped></Coordinate></coordinates>
    <frames><PhysicalOffsetFrame name="thigh_frame"><socket_parent>/ground</socket_parent>
      <translation>0 1 0</translation><orientation>0.1 0 0</orientation></PhysicalOffsetFrame>
    </frames>
    <SpatialTransform>
      <TransformAxis name="rotation1"><coordinates>knee_angle</coordinates><axis>0 0 2</axis>
        <LinearFunction name="function"><coefficients>1 0</coefficients></LinearFunction>
      </TransformAxis>
      <TransformAxis name="translation2"><coordinates>knee_angle</coordinates><axis>0 1 0</axis>
        <MultiplierFunction><function><PolynomialFunction><coefficients>3 2 1</coefficients>
        </PolynomialFunction></function><scale>0.01</scale></MultiplierFunction></TransformAxis>
      <TransformAxis name="translation3"><coordinates/><axis>0 0 1</axis>
        <Constant><value>0.05</value></Constant></TransformAxis>
    </SpatialTransform></CustomJoint>
</objects></JointSet>
<ConstraintSet><objects>
  <CoordinateCouplerConstraint name="c"><coupled_coordinates_function><LinearFunction>
      <coefficients>2 1</coefficients></LinearFunction></coupled_coordinates_function>
    <independent_coordinate_names>knee_angle</independent_coordinate_names>
    <dependent_coordinate_name>pat_angle</dependent_coordinate_name><scale_factor>0.5</scale_factor>
  </CoordinateCouplerConstraint>
  <PointConstraint name="loop"/>
</objects></ConstraintSet>
<ForceSet><objects>
  <Thelen2003Muscle name="vas"><max_isometric_force>500</max_isometric_force><Af>0.3</Af>
    <GeometryPath><PathPointSet><objects>
      <PathPoint name="1"><socket_parent_frame>/ground</socket_parent_frame>
        <location>0.05 0.9 0</location></PathPoint>
      <ConditionalPathPoint name="2"><socket_parent_frame>/bodyset/shank</socket_parent_frame>
        <location>0.04 0 0</location><range>-1 0</range>
        <socket_coordinate>/jointset/knee/knee_angle</socket_coordinate></ConditionalPathPoint>
      <PathPoint name="3"><socket_parent_frame>/bodyset/patella</socket_parent_frame>
        <location>0.02 0 0</location></PathPoint></objects></PathPointSet>
      <PathWrapSet><objects><PathWrap name="w"><wrap_object>heel</wrap_object>
        <range>-1 -1</range></PathWrap></objects></PathWrapSet></GeometryPath></Thelen2003Muscle>
  <CoordinateLimitForce name="stop"><coordinate>knee_angle</coordinate>
    <upper_limit>90</upper_limit><upper_stiffness>2</upper_stiffness><lower_limit>-45</lower_limit>
    <lower_stiffness>1</lower_stiffness><damping>0.1</damping><transition>10</transition>
  </CoordinateLimitForce>
  <CoordinateActuator name="motor"><coordinate>knee_angle</coordinate>
    <optimal_force>50</optimal_force><min_control>-1</min_control><max_control>2</max_control>
  </CoordinateActuator>
  <HuntCrossleyForce name="floor"><HuntCrossleyForce::ContactParametersSet name="p"/>
  </HuntCrossleyForce>
</objects></ForceSet>
</Model></OpenSimDocument>
"""


def of_text(folder: Path, text: str = MODEL) -> Path:
    file = folder / "leg.osim"
    file.write_text(text)
    return file


def test_every_part_of_a_small_model_is_read_or_named(tmp_path: Path) -> None:
    reading = read(of_text(tmp_path))
    robot = reading.require()
    knee, patella = robot.joint("knee"), robot.joint("pat").coordinates[0]
    kinds = [(motion.kind, motion.axis) for motion in knee.motions]
    assert kinds == [("translation", (0, 1, 0)), ("translation", (0, 0, 1)),
                     ("rotation", (0, 0, 1))]  # fmt: skip
    np.testing.assert_allclose(derivatives(knee.motions[0].function, 2.0), (0.17, 0.14, 0.06))
    assert knee.motions[1].way(0.7) == 0.05
    assert knee.T_parent_joint.rpy == pytest.approx((0.1, 0.0, 0.0))
    (term,) = patella.coupling
    assert (term.coordinate, term.function) == ("knee_angle", Polynomial((0.5, 1.0)))
    (free,) = robot.coordinates
    assert (free.lower, free.upper, free.initial) == (-2.0, 0.2, 0.3)
    assert (free.actuated, free.tau_min, free.tau_max) == (True, -50.0, 100.0)
    assert free.limit_force is not None
    degree = math.pi / 180.0
    assert free.limit_force.high == pytest.approx(math.pi / 2)
    assert free.limit_force.stiffness_high == pytest.approx(2.0 / degree)
    muscle = robot.muscle("vas")
    values = law_parameters(muscle.model)
    assert (values["max_isometric_force"], values["concentric_shape"]) == (500.0, 0.3)
    assert (values["optimal_fibre_length"], values["elastic_tendon"]) == (0.1, 1.0)
    condition, (wrap,) = muscle.via_points[1].when, muscle.wraps
    assert condition is not None
    assert (condition.coordinate, condition.high) == ("knee_angle", 1e-5)
    assert (wrap.rule, wrap.segment, wrap.last_segment, wrap.quadrant) == ("opensim", 0, 1, "+x")
    said = {finding.code: str(finding) for finding in reading.findings}
    assert "'loop'" in said["loop-left-out"]
    assert "HuntCrossleyForce" in said["force-left-out"]
    line = MODEL[: MODEL.index("<HuntCrossleyForce")].count("\n") + 1
    assert f":{line}: " in said["force-left-out"]


def test_older_files_are_refused_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="joints are inside of bodies; open it in OpenSim 4"):
        read(of_text(tmp_path, MODEL.replace('"40000"', '"30000"')))


SHARED = {
    "arm26": 11,
    "gait10dof18musc": 198,
    "gait2392_thelen2003muscle": 1012,
    "leg6dof9musc": 99,
    "subject_walk_scaled": 418,
}
"""Poses of muscles without wraps."""


@pytest.mark.parametrize("name", SHARED)
def test_masses_gravity_and_lengths_are_those_of_opensim(shared: Path, name: str) -> None:
    file = shared / f"models/opensim/{name}.osim"
    reference = json.loads((shared / f"reference/opensim/{name}.json").read_text())
    reading = read(file)
    robot = reading.require()
    order = [c["name"] for c in reference["coordinates"]]
    compared = 0
    for pose in reference["poses"]:
        at = MovingLinks(robot, dict(zip(order, pose["q"], strict=True)))
        rows = [at.names.index(c) for c in order]
        M, g = at.mass_and_gravity()
        for ours, theirs in ((M[np.ix_(rows, rows)], pose["M"]), (g[rows], pose["gravity_torque"])):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * np.abs(theirs).max())
        for muscle, length in zip(reference["muscles"], pose["length"], strict=True):
            if not muscle["wraps"]:
                ours = at.straight_length(robot.muscle(muscle["name"]))
                assert ours == pytest.approx(length, rel=1e-14)
                compared += 1
    assert compared == SHARED[name]
