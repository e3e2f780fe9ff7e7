"""Designs with properties that other exporters cannot handle."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from ..build import Builder
from ..maths import rotation, translation
from ..model.shapes import Box
from .arm import two_link_arm
from .parts import chain, muscle, nested_place, random_motion

LINKS = ("base", "upper", "lower")


# Joints ------------------------------------------------------------------------------------------


def as_built_only() -> Any:
    """All joints are as-built; a rigid one connects a lid to the last link."""
    build = Builder("as built")
    paths = chain(build, as_built=True)
    lid = build.place("lid", translation((0.0, 0.0, 30.0)))
    build.box(lid, (2.0, 3.0, 0.5), translation((0.0, 0.0, 0.25)))
    build.joint("lid_joint", "rigid", lid, paths[-1], (0.0, 0.0, 30.0), as_built=True)
    build.rigid_group("EXPORT_lid", [lid])
    muscle(build, 0, list(zip(LINKS, paths, strict=True)))
    return build.done()


def joint_origins() -> Any:
    """Joint origins define every joint."""
    build = Builder("joint origins")
    paths = chain(build, by_origins=True)
    muscle(build, 0, list(zip(LINKS, paths, strict=True)))
    return build.done()


def joint_to_root(*, root_body: bool = False) -> Any:
    """The first link is joined to the root component: its second occurrence is null.

    Args:
        root_body: Whether the root component has a body.
    """
    build = Builder("to the root")
    paths = chain(build, ("upper", "lower"))
    paths[0][0].grounded = False
    build.joint("root_joint", "revolute", paths[0], (), axis=(0.0, 1.0, 0.0), values=(0.2,))
    if root_body:
        build.box((), (8.0, 8.0, 1.0), translation((0.0, 0.0, -0.5)), name="plate")
    return build.done()


def closed_loop() -> Any:
    """Four bars: base, left, right, top; joints a, b, c, d form a closed loop."""
    build = Builder("four bars")
    base = build.place("base", grounded=True)
    build.box(base, (20.0, 2.0, 1.0))
    left = build.place("left", translation((-8.0, 0.0, 0.0)))
    right = build.place("right", translation((8.0, 0.0, 0.0)))
    top = build.place("top", translation((0.0, 0.0, 10.0)))
    for bar in (left, right):
        build.box(bar, (1.0, 1.0, 10.0), translation((0.0, 0.0, 5.0)))
    build.box(top, (17.0, 1.0, 1.0))
    y = (0.0, 1.0, 0.0)
    build.joint("a", "revolute", left, base, (-8.0, 0.0, 0.0), y)
    build.joint("b", "revolute", right, base, (8.0, 0.0, 0.0), y)
    build.joint("c", "revolute", top, left, (-8.0, 0.0, 10.0), y)
    build.joint("d", "revolute", top, right, (8.0, 0.0, 10.0), y)
    for name, path in (("base", base), ("left", left), ("right", right), ("top", top)):
        build.rigid_group(f"EXPORT_{name}", [path])
    return build.done()


def assembly_constraints() -> Any:
    """The root has an assembly constraint next to its joints: allJoints fails."""
    build = Builder("constraints")
    chain(build)
    build.constraint()
    return build.done()


def inferred_joint() -> Any:
    """One joint is inferred from constraints: geometry and motion are null."""
    build = Builder("inferred")
    paths = chain(build, ("base", "upper"))
    lower = build.place("lower", translation((0.0, 0.0, 20.0)))
    build.box(lower, (2.0, 3.0, 10.0), translation((0.0, 0.0, 5.0)))
    build.joint("lower_joint", "inferred", lower, paths[-1], (0.0, 0.0, 20.0))
    build.rigid_group("EXPORT_lower", [lower])
    return build.done()


def suppressed_and_broken() -> Any:
    """`upper_joint` is valid, `lower_joint` has lost its geometry, `old` is suppressed."""
    build = Builder("broken")
    paths = chain(build)
    broken = build.root.joints[1]
    broken.health, broken.broken_geometry = 2, True
    broken.problem = "Reference Failures: the geometry of the joint was deleted"
    build.joint("old", "slider", paths[2], paths[0], (0.0, 0.0, 20.0), suppressed=True)
    build.rigid_group("EXPORT_old", [paths[2]], suppressed=True)
    return build.done()


def locked_joint() -> Any:
    """`lower_joint` is locked at its value."""
    build = Builder("locked")
    chain(build)
    build.root.joints[1].locked = True
    return build.done()


def joint_with_offset() -> Any:
    """`lower_joint` has an offset of 3 cm along its axis, an angle of 0.4 rad, and is flipped."""
    build = Builder("offset")
    paths = chain(build, ("base", "upper"))
    T = translation((0.0, 3.0, 20.0)) @ rotation(0.4, (0.0, 1.0, 0.0))
    lower = build.place("lower", T)
    build.box(lower, (2.0, 3.0, 10.0), translation((0.0, 0.0, 5.0)))
    build.joint(
        "lower_joint",
        "revolute",
        lower,
        paths[1],
        (0.0, 0.0, 20.0),
        (0.0, 1.0, 0.0),
        offsets=(0.0, 0.0, 3.0),
        angle=0.4,
        flipped=True,
    )
    build.rigid_group("EXPORT_lower", [lower])
    return build.done()


def limits() -> Any:
    """Limits: none, lower only, upper only, both, and 0 to 0 enabled, on `joint_1` .. `joint_5`."""
    build = Builder("limits")
    names = ("base", "a", "b", "c", "d", "e")
    chain(build, names, joints=[f"joint_{i}" for i in range(1, 6)], limits=(None, None))
    bounds = ((None, None), (-0.5, None), (None, 0.75), (-0.5, 0.75), (0.0, 0.0))
    for joint, (lower, upper) in zip(build.root.joints, bounds, strict=True):
        held = joint.freedoms[0].limits
        held.has_minimum, held.has_maximum = lower is not None, upper is not None
        held.minimum, held.maximum = lower or 0.0, upper or 0.0
    return build.done()


# Structure ---------------------------------------------------------------------------------------


def rigid_groups() -> Any:
    """Links of several components, some nested; one nested part is not in a group."""
    build = Builder("rigid groups")
    paths = chain(build, groups=False)
    order = random.Random(5)
    bracket = build.place("bracket", random_motion(order, 5.0), above=paths[1])
    build.box(bracket, (1.0, 2.0, 3.0))
    screw = build.place("screw", random_motion(order, 5.0), above=bracket)
    build.cylinder(screw, 0.3, 2.0)
    motor = build.place("motor", random_motion(order, 20.0))
    build.cylinder(motor, 2.0, 5.0)
    build.rigid_group("EXPORT_base", [paths[0], motor])
    build.rigid_group("EXPORT_upper", [paths[1], bracket])
    build.rigid_group("EXPORT_lower", [paths[2]])
    build.rigid_group("screws", [screw])
    muscle(build, 0, list(zip(LINKS, paths, strict=True)))
    return build.done()


def nested_rotated(seed: int = 11) -> Any:
    """Every link is a nested, rotated occurrence; joints are in sub-assemblies at two levels."""
    build = Builder("nested")
    order = random.Random(seed)
    arm = build.place("arm assembly", random_motion(order))
    base = build.place("base", random_motion(order), above=arm, grounded=True)
    fore = build.place("forearm assembly", random_motion(order), above=arm)
    upper = build.place("upper", random_motion(order), above=fore)
    lower = build.place("lower", random_motion(order), above=fore)
    for path in (base, upper, lower):
        build.box(path, (2.0, 3.0, 10.0), random_motion(order, 3.0))
    T = random_motion(order)
    build.joint("elbow", "revolute", lower, upper, T=T, values=(0.4,), inside=fore)
    T = random_motion(order)
    build.joint(
        "shoulder", "revolute", upper, base, T=T, values=(-0.2,), inside=arm, limits=((-1.0, 1.0),)
    )
    for name, path in (("base", base), ("upper", upper), ("lower", lower)):
        build.rigid_group(f"EXPORT_{name}", [path], inside=path[:-1])
    muscle(build, 0, [("base", base), ("upper", upper), ("lower", lower)])
    return build.done()


def component_twice() -> Any:
    """Component `finger` has two occurrences, left and right; each is a link with a via point."""
    build = Builder("twice")
    base = build.place("palm", grounded=True)
    build.box(base, (10.0, 4.0, 2.0))
    left = build.place("finger", translation((-4.0, 0.0, 1.0)))
    build.box(left, (1.0, 1.0, 6.0), translation((0.0, 0.0, 3.0)))
    T = translation((4.0, 0.0, 1.0)) @ rotation(np.pi / 2, (0.0, 0.0, 1.0))
    right = build.place(left[-1].component, T)
    build.joint("left_joint", "revolute", left, base, (-4.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    build.joint("right_joint", "revolute", right, base, (4.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    build.point(base, (-4.0, 1.0, 1.0), "VP_motor0_EXPORT_palm_0")
    build.point(left, (0.0, 0.5, 5.0), "VP_motor0_EXPORT_left_1")
    for name, path in (("palm", base), ("left", left), ("right", right)):
        build.rigid_group(f"EXPORT_{name}", [path])
    return build.done()


def referenced_components(*, points: bool = True) -> Any:
    """The link `lower` comes from another document and cannot be edited."""
    build = Builder("referenced")
    paths = chain(build)
    paths[2][-1].component.referenced = True
    if points:
        muscle(build, 0, list(zip(LINKS, paths, strict=True)))
    return build.done()


def no_groups() -> Any:
    """Components and joints without rigid groups; the original failed in the progress dialog."""
    build = Builder("no groups")
    chain(build, groups=False)
    return build.done()


def occurrence_in_two_groups() -> Any:
    """`upper` is in the rigid groups of two links."""
    build = Builder("two groups")
    paths = chain(build)
    build.root.groups[2].members.append(paths[1])
    return build.done()


def body_in_no_group() -> Any:
    """The component `cover` and the body `plate` of the root are not in a rigid group."""
    build = Builder("ungrouped")
    chain(build)
    cover = build.place("cover", translation((20.0, 0.0, 0.0)))
    build.box(cover, (1.0, 1.0, 1.0))
    build.box((), (5.0, 5.0, 1.0), translation((0.0, 20.0, 0.0)), name="plate")
    return build.done()


def disconnected() -> Any:
    """The link `alone` has no joint."""
    build = Builder("disconnected")
    chain(build)
    alone = build.place("alone", translation((20.0, 0.0, 0.0)))
    build.box(alone, (1.0, 1.0, 1.0))
    build.rigid_group("EXPORT_alone", [alone])
    return build.done()


# Bodies ------------------------------------------------------------------------------------------


def small_parts() -> Any:
    """Links of less than a gram: inertias of 1e-10 kg·m² that must not be rounded to zero."""
    build = Builder("small")
    paths = chain(build, groups=True, length=0.4)
    for path in paths:
        component = path[-1].component
        component.bodies.clear()
        build.box(path, (0.2, 0.3, 0.4), translation((0.0, 0.0, 0.2)), density=1.2e-3)
    return build.done()


def overridden_mass(mass: float = 2.5) -> Any:
    """The user has set the mass of `upper`, which contains another part, in [kg]."""
    build = Builder("overridden")
    paths = chain(build)
    part = build.place("part", translation((1.5, 0.0, 5.0)), above=paths[1])
    build.sphere(part, 1.0)
    paths[1][-1].component.user_mass = mass
    return build.done()


def l_shape() -> Any:
    """`lower` is an L shape of two boxes: several bodies in one component."""
    build = Builder("L")
    paths = chain(build)
    build.box(paths[2], (6.0, 3.0, 2.0), translation((4.0, 0.0, 1.0)), name="foot")
    return build.done()


def surface_and_mesh_bodies() -> Any:
    """`upper` has a surface and a mesh body in addition to its solid; `lower` has a mesh body."""
    build = Builder("surfaces")
    paths = chain(build)
    T = translation((0.0, 0.0, 5.0))
    build.body(paths[1], Box(T, size=(4.0, 4.0, 1.0)), "skin", kind="surface")
    build.body(paths[1], Box(T, size=(4.0, 4.0, 2.0)), "scan", kind="mesh")
    lower = paths[2][-1].component
    lower.bodies.clear()
    build.body(lower, Box(T, size=(2.0, 3.0, 10.0)), "scan", kind="mesh")
    return build.done()


def hidden_bodies() -> Any:
    """A body of `upper` is hidden; so is the whole occurrence `lower`."""
    build = Builder("hidden")
    paths = chain(build)
    build.box(paths[1], (1.0, 1.0, 1.0), translation((3.0, 0.0, 0.0)), name="jig", visible=False)
    paths[2][-1].light_bulb = False
    return build.done()


def no_material() -> Any:
    """The body of `lower` has no material and no mass."""
    build = Builder("no material")
    paths = chain(build)
    body = paths[2][-1].component.bodies[0]
    body.material, body.density = "", 0.0
    return build.done()


# Names -------------------------------------------------------------------------------------------


def name_clash() -> Any:
    """The joint `upper` has the same name as its child link."""
    build = Builder("clash")
    chain(build, joints=("upper", "lower_joint"))
    return build.done()


def duplicate_names() -> Any:
    """Via points that Fusion has renamed: `..._1` and `..._1 (1)`; two components called `part`."""
    build = Builder("duplicates")
    paths = chain(build)
    muscle(build, 0, list(zip(LINKS, paths, strict=True)))
    build.point(paths[1], (1.0, 1.0, 6.0), "VP_motor0_EXPORT_upper_1")
    for _ in range(2):
        part = build.place("part", translation((2.0, 0.0, 0.0)), above=paths[1])
        build.box(part, (0.5, 0.5, 0.5))
    return build.done()


def odd_link_names() -> Any:
    """Links `a_0`, `a_0_1`, `2b`: underscores and digits that make names ambiguous."""
    names = ("a_0", "a_0_1", "2b")
    build = Builder("odd names")
    paths = chain(build, names)
    muscle(build, 0, list(zip(names, paths, strict=True)))
    muscle(build, 10, list(zip(names, paths, strict=True)), side=-1.0)
    return build.done()


def many_numbers() -> Any:
    """A muscle with via points 0 to 11 on two links: `10` must come after `9`."""
    build = Builder("numbers")
    paths = chain(build, ("base", "upper"))
    for k in range(12):
        link, path = ("base", paths[0]) if k < 6 else ("upper", paths[1])
        build.point(path, (1.0, 0.0, float(k % 6)), f"VP_motor0_EXPORT_{link}_{k}")
    return build.done()


def case_differences() -> Any:
    """Via points name `Upper` and `LOWER`; the links are `upper` and `lower`."""
    build = Builder("case")
    paths = chain(build)
    muscle(build, 0, [("base", paths[0]), ("Upper", paths[1]), ("LOWER", paths[2])])
    return build.done()


def unexported_link() -> Any:
    """A via point refers to the unknown link `?`: issue 5 of the original."""
    build = Builder("unexported")
    paths = chain(build)
    muscle(build, 0, [("base", paths[0]), ("?", paths[1])])
    return build.done()


def unicode_names() -> Any:
    """Names in other scripts, and with special characters of XML and file systems."""
    names = ("основа", "上臂", 'ell"bow <&>')
    build = Builder("Schülter – 肩")
    paths = chain(build, names)
    muscle(build, 0, list(zip(names, paths, strict=True)))
    return build.done()


def old_markers() -> Any:
    """`EE_`, `VM_` and `COM_` points of old designs."""
    build = Builder("old")
    paths = chain(build)
    muscle(build, 0, list(zip(LINKS, paths, strict=True)))
    build.point(paths[2], (0.0, 0.0, 10.0), "EE_lower")
    build.point(paths[1], (1.0, 0.0, 3.0), "VM_upper")
    build.point(paths[1], (0.0, 0.0, 5.0), "COM_upper")
    return build.done()


# Types of design ---------------------------------------------------------------------------------


def y_up() -> Any:
    """The arm is along y, which is the up axis in the preferences of the user."""
    from ..state import world

    world().modeling_orientation = 0
    return two_link_arm(motion=rotation(-np.pi / 2, (1.0, 0.0, 0.0)))


def assembly_intent() -> Any:
    """An assembly design: components come from other documents; the root has no features."""
    build = Builder("assembly", intent="assembly")
    chain(build)
    return build.done()


def part_intent() -> Any:
    """A part design: bodies in the root, no occurrences."""
    build = Builder("part", intent="part")
    build.box((), (2.0, 3.0, 10.0))
    build.cylinder((), 1.0, 4.0, translation((0.0, 0.0, 7.0)))
    return build.done()


def direct_modelling() -> Any:
    """A design without timeline, which accepts points at any position."""
    build = Builder("direct", parametric=False)
    chain(build)
    return build.done()


def things_to_pick(seed: int | None = None) -> Any:
    """Links with all entities that can be picked: boxes, cylinders, spheres, tori, sketches.

    `base`: a box and a sketch of the user with a point. `upper`: a cylinder about x and a sphere.
    `lower`: a torus, a nested part `tip` with a box, and a construction point `mine` of the user.
    """
    build = Builder("to pick")
    order = random.Random(seed)
    base = build.place("base", grounded=True)
    upper, lower = (
        nested_place(
            build,
            name,
            translation((0.0, 0.0, z)) if seed is None else random_motion(order),
            order,
            0 if seed is None else 1,
        )
        for name, z in (("upper", 10.0), ("lower", 20.0))
    )
    build.box(base, (4.0, 4.0, 10.0), translation((0.0, 0.0, 5.0)))
    build.sketch(
        base,
        translation((0.0, 0.0, 10.0)),
        points=[(1.0, 1.0, 0.0)],
        name="user sketch",
    )
    build.sketch((), points=[(30.0, 0.0, 0.0)], name="root sketch")
    turn = rotation(np.pi / 2, (0.0, 1.0, 0.0))
    build.cylinder(upper, 1.5, 8.0, translation((0.0, 0.0, 2.0)) @ turn)
    build.sphere(upper, 1.0, translation((0.0, 0.0, 7.0)))
    build.torus(lower, 3.0, 0.5, translation((0.0, 0.0, 2.0)))
    tip = build.place("tip", translation((0.0, 0.0, 8.0)), above=lower)
    build.box(tip, (1.0, 1.0, 1.0))
    build.point(lower, (0.0, 0.0, 5.0), "mine")
    y = (0.0, 1.0, 0.0)
    build.joint("upper_joint", "revolute", upper, base, (0.0, 0.0, 10.0), y)
    build.joint("lower_joint", "revolute", lower, upper, (0.0, 0.0, 20.0), y)
    for name, path in (("base", base), ("upper", upper), ("lower", lower)):
        build.rigid_group(f"EXPORT_{name}", [path])
    return build.done()
