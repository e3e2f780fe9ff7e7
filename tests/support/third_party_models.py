"""Small models in the formats of other programs, with many of their features."""

from __future__ import annotations

from dataclasses import replace

from addin_sdfusion.robot import Robot

URDF = """<?xml version="1.0"?>
<robot name="arm">
  <mujoco><compiler meshdir="m" strippath="false"/><option gravity="0 0 -1.6"/></mujoco>
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/><mass value="2"/>
      <inertia ixx="0.03" ixy="0.001" ixz="-0.002" iyy="0.04" iyz="0.003" izz="0.05"/>
    </inertial>
    <visual>
      <geometry><mesh filename="package://arm/a.stl" size="1 1 1" scale="2 2 2"/></geometry>
    </visual>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0 0 0.1"/><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/>
    </inertial>
  </link>
  <link name="tip">
    <inertial>
      <mass value="0.5"/>
      <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.002"/>
    </inertial>
  </link>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0.2 0.5" rpy="0 0.7 0.2"/><parent link="upper"/><child link="fore"/>
    <axis xyz="0 3 4"/><limit lower="-0.1" upper="0.2" effort="7" velocity="1"/>
    <dynamics damping="0.3" friction="0.2"/>
  </joint>
  <joint name="shoulder" type="continuous">
    <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><parent link="base"/><child link="upper"/>
    <axis xyz="1 2 2"/>
  </joint>
  <joint name="end" type="fixed">
    <origin xyz="0 0 1" rpy="0 0 1"/><parent link="fore"/><child link="tip"/>
  </joint>
  <transmission name="t"><joint name="slide"/><actuator name="m"/></transmission>
  <gazebo/>
</robot>
"""

OSIM = """<?xml version="1.0" encoding="UTF-8"?>
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
  <PointConstraint name="loop"><socket_body_1>/bodyset/shank</socket_body_1>
    <socket_body_2>/jointset/knee/thigh_frame</socket_body_2>
    <location_body_1>0 0.1 0</location_body_1><location_body_2>0 0.2 0.01</location_body_2>
  </PointConstraint>
  <WeldConstraint name="weld"><socket_frame1>on_patella</socket_frame1>
    <socket_frame2>/bodyset/shank</socket_frame2><frames>
      <PhysicalOffsetFrame name="on_patella"><socket_parent>/bodyset/patella</socket_parent>
        <translation>0 0 0.1</translation><orientation>0 0 0.2</orientation></PhysicalOffsetFrame>
    </frames></WeldConstraint>
  <WeldConstraint name="off"><isEnforced>false</isEnforced></WeldConstraint>
  <ConstantDistanceConstraint name="rod"><socket_body_1>/bodyset/shank</socket_body_1>
    <socket_body_2>/ground</socket_body_2><constant_distance>0.5</constant_distance>
  </ConstantDistanceConstraint>
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
  <PathSpring name="band"><resting_length>0.3</resting_length><stiffness>200</stiffness>
    <dissipation>0.01</dissipation><GeometryPath><PathPointSet><objects>
      <PathPoint name="1"><socket_parent_frame>/ground</socket_parent_frame>
        <location>0.05 0.9 0</location></PathPoint>
      <PathPoint name="2"><socket_parent_frame>/bodyset/shank</socket_parent_frame>
        <location>0.04 0 0</location></PathPoint></objects></PathPointSet></GeometryPath>
  </PathSpring>
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

MJCF = """<mujoco model="arm">
<compiler angle="degree" eulerseq="zyx" boundmass="0.05" boundinertia="0.001"
  balanceinertia="true"/>
<include file="options.xml"/>
<default>
  <geom density="800"/>
  <default class="soft"><joint damping="0.5" armature="0.01"/><geom density="400"/>
    <default class="pull"><muscle ctrlrange="0 1" scale="300"/></default></default>
</default>
<worldbody><site name="base" pos="0 0 1"/>
  <include file="arm.xml"/>
</worldbody>
<tendon>
  <spatial name="t"><site site="base"/><geom geom="ball" sidesite="side"/><site site="hand"/>
    <pulley divisor="2"/><site site="hand"/><site site="tip"/></spatial>
  <fixed name="f"><joint joint="turn" coef="0.02"/><joint joint="slide" coef="-0.5"/></fixed>
</tendon>
<equality><joint joint1="slide" joint2="swing" polycoef="0.1 0.2 0.3"/>
  <weld body1="hand" body2="upper"/></equality>
<actuator><muscle name="m" tendon="t" class="pull"/><motor name="w" joint="turn" gear="2"
  ctrllimited="true" ctrlrange="-3 4"/>
  <motor name="c" tendon="f" gear="-1" ctrllimited="true" ctrlrange="0 50"/></actuator>
<sensor><jointpos joint="turn"/></sensor></mujoco>
"""

INCLUDED = """<mujocoinclude><!-- a -- b -->
<body name="upper" pos="0 0.1 0" euler="10 20 30" childclass="soft">
  <joint name="turn" pos="0.1 0 0"axis="0 1 1" range="-40 50" ref="15"/>
  <joint name="swing" pos="0 0.05 0" axis="1 0 0" range="-30 30" ref="-10"/>
  <geom type="capsule" fromto="0 0 0 0.1 0.2 0.3" size="0.03"/>
  <geom name="ball" size="0.02" pos="0.02 0.1 0.4" mass="0"/><site name="side" pos="0.1 0.1 0.5"/>
  <frame pos="0 0 0.3" axisangle="0 0 1 90">
    <body name="hand" pos="0 0 0.1" zaxis="0 1 1"><joint name="slide" type="slide" axis="1 0 0"
        range="-0.2 0.3" ref="0.1"/>
      <inertial pos="0.01 0 0" quat="0.5 0.5 -0.5 0.5" mass="0.01" diaginertia="1e-2 1e-3 1e-3"/>
      <site name="hand" pos="0 0.05 0"/><geom type="box" size="0.1 0.1 0.1"/></body></frame>
  <body name="bits" xyaxes="0 1 0 -1 0 0"><joint name="wrist" range="-9 9"/>
    <geom type="cylinder" size="0.02 0.1" class="main"/>
    <geom type="ellipsoid" size="0.02 0.03 0.04" pos="0 0.1 0"/><site name="tip" pos="0 0 0.2"/>
    <geom type="box" size="0.02 0.03 0.04" pos="0.1 0 0" density="0"/></body>
</body></mujocoinclude>
"""

OPTIONS = """<mujocoinclude><option gravity="0 1 -9"/></mujocoinclude>
"""
BODY = INCLUDED.partition("-->")[2].rpartition("<")[0].replace('0"a', '0" a')
WHOLE_MJCF = MJCF.replace('<include file="arm.xml"/>', BODY)
WHOLE_MJCF = WHOLE_MJCF.replace('<include file="options.xml"/>', '<option gravity="0 1 -9"/>')
"""Model without includes, as well-formed XML."""

SQUAT = """
[robot]
path = "P2.osim"

[start]
q = { hip_flexion_r = -2.0, knee_angle_r = -2.0, ankle_angle_r = -0.5 }

[motion]
duration = 1.0
goals = [{ q = 0.0 }]

[motion.cost]  # 1 / (150, 300, 150 N·m)²
forces = { hip_flexion_r = 4.444444444444444e-5, knee_angle_r = 1.1111111111111111e-5, ankle_angle_r = 4.444444444444444e-5 }

[motion.bounds]
q_min = { hip_flexion_r = -2.0, knee_angle_r = -2.0, ankle_angle_r = -0.5 }
q_max = { hip_flexion_r = 0.5, knee_angle_r = 0.0, ankle_angle_r = 0.7 }

[controller]
kp = 400.0
kd = 40.0
"""  # noqa: E501
"""Experiment of the model P2.osim of OpenSim Moco, with torques."""

REACH = """
[robot]
path = "P3.osim"
[start]
q = { r_shoulder_elev = 0.07, r_elbow_flex = 1.4 }
[motion]
muscles = "laws"
start_command = 0.05
duration = 0.5
goals = [{ q = { r_shoulder_elev = 0.6, r_elbow_flex = 0.9 } }]
[motion.bounds]
qd_max = 20.0
q_min = { r_shoulder_elev = -1.0, r_elbow_flex = 0.1 }
q_max = { r_shoulder_elev = 2.0, r_elbow_flex = 2.2 }
u_min = 0.01
u_max = 1.0
[motion.cost]
commands = 1.0
[controller]
kp = 400.0
kd = 40.0
"""
"""Experiment of the model P3.osim of OpenSim Moco, with muscles."""


def without_ellipsoids(robot: Robot) -> Robot:
    """Return a robot whose muscles do not wrap over ellipsoids.

    Over ellipsoids, the moment arms of OpenSim are not the derivatives of its lengths.
    """
    ellipsoids = {s.name for s in robot.wrap_surfaces if s.shape == "ellipsoid"}
    return robot.with_muscles(
        [
            replace(m, wraps=tuple(w for w in m.wraps if w.surface not in ellipsoids))
            for m in robot.muscles
        ]
    )
