"""The two-link arm of the CARDSFlow paper, drawn with build123d: in millimetres, standing upright.

cardsflow import-cad examples/from_cad/two_link_arm.py -o arm
cardsflow run arm -o results
"""

from math import pi

from build123d import (
    Align,
    Axis,
    Box,
    Compound,
    Cylinder,
    Location,
    Pos,
    RevoluteJoint,
    RigidJoint,
    Sphere,
)

from cardsflow_fmu.cad import Design

LENGTH, MASS = 1000.0, 0.1  # [mm], [kg]
GOLD = 19300e-9  # [kg/mm³]; the densest ball is the nearest to the paper's point masses
RADIUS = (3.0 * MASS / (4.0 * pi * GOLD)) ** (1 / 3)  # [mm]


def link(name: str) -> Compound:
    """Return a massless bar, without material, with a ball at its middle."""
    bar = Box(20, 20, LENGTH, align=(Align.CENTER, Align.CENTER, Align.MIN))
    bar.label = "bar"
    ball = Pos(0, 0, LENGTH / 2) * Sphere(RADIUS)
    ball.label, ball.material = "ball", "gold"
    assembly = Compound(label=name, children=[bar, ball])
    RigidJoint("foot", assembly, Axis.Y.location)  # its z axis becomes the joint axis
    for side, x in (("left", -100), ("right", 100)):  # attachments of muscles
        RigidJoint(side, assembly, Location((x, 0, 0.8 * LENGTH)))
    return assembly


base = Cylinder(50, 20, align=(Align.CENTER, Align.CENTER, Align.MAX))
base.label, base.material = "base", "aluminum"
link_1, link_2 = link("link_1"), link("link_2")

joint_1 = RevoluteJoint("joint_1", base, Axis.Y, angular_range=(-180, 180))
joint_1.connect_to(link_1.joints["foot"], angle=0)
joint_2 = RevoluteJoint(
    "joint_2", link_1, Axis((0, 0, LENGTH), (0, 1, 0)), angular_range=(-180, 180)
)
joint_2.connect_to(link_2.joints["foot"], angle=0)

design = Design(Compound(label="two_link_arm", children=[base, link_1, link_2]))
for name, x, end in (
    ("cable_1", 500, link_1.joints["right"]),
    ("cable_2", 1500, link_2.joints["right"]),
    ("cable_3", -500, link_1.joints["left"]),
    ("cable_4", -1500, link_2.joints["left"]),
):
    design.muscle(name, (base, (x, 0, 0)), end, f_min=10, f_max=100)
design.task("tip", (link_2, (0, 0, LENGTH)), axes="xz")
