"""Tests of assemblies, bodies and joints of the fake against closed forms and meshes."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from fake_fusion import Builder, Fake, designs
from fake_fusion.build import FREEDOMS
from fake_fusion.designs import random_motion
from fake_fusion.maths import rotation, translation, xyz

VERY_HIGH = 3


def cells(m: Any) -> np.ndarray:
    return np.array(m.asArray()).reshape(4, 4)


def by_path(design: Any) -> dict[str, Any]:
    return {o.fullPathName: o for o in design.rootComponent.allOccurrences}


def moments(properties: Any) -> np.ndarray:
    """Return the inertia matrix about the origin, in [kg·cm²], from the tuple of Fusion."""
    ok, xx, yy, zz, xy, yz, xz = properties.getXYZMomentsOfInertia()
    assert ok is True
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def about_com(properties: Any) -> np.ndarray:
    r = xyz(properties.centerOfMass)
    return moments(properties) - properties.mass * (r @ r * np.eye(3) - np.outer(r, r))


def mesh_of(body: Any, quality: int = 15) -> trimesh.Trimesh:
    calculator = body.meshManager.createMeshCalculator()
    assert calculator.setQuality(quality)
    mesh = calculator.calculate()
    nodes = np.array(mesh.nodeCoordinatesAsDouble).reshape(-1, 3)
    triangles = np.array(mesh.nodeIndices).reshape(-1, 3)
    return trimesh.Trimesh(nodes, triangles, process=False)


# Assemblies --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_poses_compose(fusion: Fake, seed: int) -> None:
    order = random.Random(seed)
    build = Builder()
    poses = [random_motion(order) for _ in range(3)]
    path: Any = ()
    for k, T in enumerate(poses):
        path = build.place(f"part {k}", T, above=path)
    design = build.done()
    found = by_path(design)
    whole = np.eye(4)
    for k, T in enumerate(poses):
        whole = whole @ T
        name = "+".join(f"part {i}:1" for i in range(k + 1))
        assert cells(found[name].transform2) == pytest.approx(whole)
        native = found[name].nativeObject
        assert (native is None) == (k == 0)
        assert cells((native or found[name]).transform2) == pytest.approx(T)
    innermost = found["part 0:1+part 1:1+part 2:1"]
    assert innermost.assemblyContext == found["part 0:1+part 1:1"]
    assert innermost.nativeObject.createForAssemblyContext(found["part 0:1+part 1:1"]) == innermost
    assert [o.name for o in found["part 0:1"].childOccurrences] == ["part 1:1"]


def test_attributes_are_found_by_group_and_name(fusion: Fake) -> None:
    design = designs.two_link_arm()
    found = design.findAttributes("CARDSFlow", "point")
    assert len(found) == 9
    assert {a.parent.name for a in found} >= {"VP_motor0_EXPORT_base_0", "EE_link_2"}
    assert len(design.findAttributes("", "re:po.*")) == 9
    assert design.findAttributes("CARDSFlow", "re:po") == []
    assert (
        design.findAttributes("CARDSFlow", "muscles") == []
    )  # attributes of the design itself are not found
    assert design.attributes.itemByName("CARDSFlow", "muscles").value.startswith("[")
    assert design.attributes.itemByName("CARDSFlow", "no") is None
    assert [a.name for a in design.attributes.itemsByGroup("CARDSFlow")] == ["muscles"]
    with fusion.building():
        with pytest.raises(RuntimeError, match="2 MB"):
            design.attributes.add("CARDSFlow", "big", "x" * (2 * 1024 * 1024 + 1))
        attribute = design.attributes.add("CARDSFlow", "small", "x" * (2 * 1024 * 1024))
        attribute.deleteMe()
    assert not attribute.isValid


# Mass --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", ["tensor", "integral"])
def test_sign_of_the_products(fusion: Fake, sign: Any) -> None:
    build = Builder()
    build.box((), (1.0, 1.0, 1.0), translation((1.0, 2.0, 3.0)), density=1.0)
    (body,) = build.done().rootComponent.bRepBodies
    fusion.options.product_sign = sign
    *_, xy, yz, xz = body.getPhysicalProperties(VERY_HIGH).getXYZMomentsOfInertia()
    integrals = np.array([2.0, 6.0, 3.0])
    assert (xy, yz, xz) == pytest.approx(integrals * (1.0 if sign == "integral" else -1.0))


SHAPES: dict[str, Callable[[Builder, Any, Any], Any]] = {
    "box": lambda build, path, T: build.box(path, (2.0, 3.0, 5.0), T),
    "cylinder": lambda build, path, T: build.cylinder(path, 1.5, 4.0, T),
    "sphere": lambda build, path, T: build.sphere(path, 2.0, T),
    "torus": lambda build, path, T: build.torus(path, 3.0, 1.0, T),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_mass_agrees_with_the_mesh(fusion: Fake, shape: str) -> None:
    """Compare with numerical integration over the mesh of a proxy, in the root frame."""
    order = random.Random(shape)
    build = Builder()
    outer = build.place("outer", random_motion(order, 5.0))
    path = build.place("part", random_motion(order, 5.0), above=outer)
    SHAPES[shape](build, path, random_motion(order, 5.0))
    (body,) = by_path(build.done())["outer:1+part:1"].bRepBodies
    mesh = mesh_of(body)
    assert mesh.is_watertight
    assert mesh.volume > 0.0  # outward
    properties = body.getPhysicalProperties(VERY_HIGH)
    mesh.density = properties.density
    tolerance = 1e-9 if shape == "box" else 5e-3
    scale = float(np.abs(about_com(properties)).max())
    assert mesh.volume == pytest.approx(properties.volume, rel=tolerance)
    assert mesh.center_mass == pytest.approx(xyz(properties.centerOfMass), abs=10 * tolerance)
    assert mesh.moment_inertia == pytest.approx(about_com(properties), abs=tolerance * scale)
    principal = properties.getPrincipalMomentsOfInertia()[1:]
    assert sorted(principal) == pytest.approx(np.linalg.eigvalsh(about_com(properties)))


def test_mass_of_an_assembly_is_the_sum_of_its_bodies(fusion: Fake) -> None:
    """Compare the parallel-axis theorem with merged meshes, for nested components."""
    build = Builder()
    order = random.Random(4)
    top = build.place("top", random_motion(order, 5.0))
    for k in range(3):
        part = build.place(f"part {k}", random_motion(order, 5.0), above=top)
        build.box(part, (1.0 + k, 2.0, 3.0), random_motion(order, 5.0))
    found = by_path(build.done())
    merged = trimesh.util.concatenate([mesh_of(o.bRepBodies[0]) for o in list(found.values())[1:]])
    merged.density = 7.85e-3
    properties = found["top:1"].getPhysicalProperties(VERY_HIGH)
    assert merged.mass == pytest.approx(properties.mass)
    assert merged.center_mass == pytest.approx(xyz(properties.centerOfMass))
    assert merged.moment_inertia == pytest.approx(about_com(properties))


# Joints ------------------------------------------------------------------------------------------

VALUES = {
    "rotation": ("rotationAxisVector", "rotationValue"),
    "slide": ("slideDirectionVector", "slideValue"),
    "primarySlide": ("primarySlideDirectionVector", "primarySlideValue"),
    "secondarySlide": ("secondarySlideDirectionVector", "secondarySlideValue"),
    "pitch": ("pitchDirectionVector", "pitchValue"),
    "yaw": ("yawDirectionVector", "yawValue"),
    "roll": ("rollDirectionVector", "rollValue"),
}


def motions_of(joint: Any, kind: str) -> list[tuple[str, np.ndarray, float]]:
    """Return role, direction and value of each degree of freedom, in order, from the API."""
    found = []
    for role, _ in FREEDOMS[kind]:
        vector, value = VALUES[role]
        if kind == "planar" and role == "rotation":
            vector = "normalDirectionVector"
        if kind == "cylindrical" and role == "slide":
            vector = "rotationAxisVector"
        motion = joint.jointMotion
        found.append((role, xyz(getattr(motion, vector)), getattr(motion, value)))
    return found


@pytest.mark.parametrize("vectors", ["fixed", "carried"])
@pytest.mark.parametrize("seed", range(3))
def test_joints_of_every_type_are_consistent(fusion: Fake, seed: int, vectors: Any) -> None:
    """The frame on `one` equals the frame on `two` moved by the values."""
    fusion.options.ball_vectors = vectors
    root = designs.every_joint_type(seed=seed).rootComponent
    for joint in root.allJoints:
        kind = joint.name.removesuffix("_joint")
        one, two = cells(joint.geometryOneTransform), cells(joint.geometryTwoTransform)
        moved = two
        turned = np.eye(3)  # rotation by the preceding degrees of freedom
        for role, direction, value in motions_of(joint, kind):
            axis = two[:3, :3].T @ direction
            if vectors == "carried" and kind == "ball":
                axis = turned.T @ axis
            if "lide" in role:
                moved = moved @ translation(value * axis)
            else:
                step = rotation(value, axis)
                moved, turned = moved @ step, turned @ step[:3, :3]
        assert moved == pytest.approx(one, abs=1e-9)
        origin = joint.geometryOrOriginTwo.origin
        assert xyz(origin) == pytest.approx(two[:3, 3])
        assert joint.occurrenceTwo.component.name == "base"


def test_limits_are_zero_until_enabled(fusion: Fake) -> None:
    held = [j.jointMotion.rotationLimits for j in designs.limits().rootComponent.allJoints]
    assert [
        (h.isMinimumValueEnabled, h.minimumValue, h.isMaximumValueEnabled, h.maximumValue)
        for h in held
    ] == [
        (False, 0.0, False, 0.0),
        (True, -0.5, False, 0.0),
        (False, 0.0, True, 0.75),
        (True, -0.5, True, 0.75),
        (True, 0.0, True, 0.0),
    ]


def test_nested_joints_read_natively_have_no_geometry(fusion: Fake) -> None:
    design = designs.nested_rotated()
    native_of = {j.name: j for o in design.rootComponent.allOccurrences for j in o.component.joints}
    assert design.rootComponent.joints.count == 0
    for proxy in design.rootComponent.allJoints:
        native = native_of[proxy.name]
        assert proxy.nativeObject == native
        assert native.geometryOrOriginOne is None
        fusion.options.nested_native_geometry = "local"
        origin = xyz(native.geometryOrOriginTwo.origin)
        assert xyz(proxy.geometryOrOriginTwo.origin) == pytest.approx(origin)
        axis = xyz(native.jointMotion.rotationAxisVector)
        assert xyz(proxy.jointMotion.rotationAxisVector) == pytest.approx(axis)
        fusion.options.nested_native_geometry = "null"
        assert proxy.occurrenceOne.fullPathName.startswith("arm assembly:1+")


def test_joint_origin_has_no_origin(fusion: Fake) -> None:
    import adsk.fusion

    for joint in designs.joint_origins().rootComponent.allJoints:
        two = joint.geometryOrOriginTwo
        assert isinstance(two, adsk.fusion.JointOrigin)
        with pytest.raises(AttributeError, match="JointOrigin has no member 'origin'"):
            _ = two.origin
        assert xyz(two.geometry.origin) == pytest.approx(cells(joint.geometryTwoTransform)[:3, 3])
        own = joint.occurrenceTwo
        T = np.eye(4) if own is None else cells(own.transform2)
        assert T @ cells(two.transform) == pytest.approx(cells(joint.geometryTwoTransform))
        assert xyz(two.geometry.primaryAxisVector) == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)


def test_inferred_joint_has_no_geometry(fusion: Fake) -> None:
    joint = designs.inferred_joint().rootComponent.joints.itemByName("lower_joint")
    geometry = ("geometryOrOriginOne", "geometryOrOriginTwo", "geometryOneTransform")
    assert [getattr(joint, name) for name in (*geometry, "jointMotion", "offset")] == [None] * 5


def test_broken_joint_keeps_its_transforms(fusion: Fake) -> None:
    import adsk.fusion

    joints = designs.suppressed_and_broken().rootComponent.joints
    broken = joints.itemByName("lower_joint")
    assert broken.healthState == adsk.fusion.FeatureHealthStates.ErrorFeatureHealthState
    assert "deleted" in broken.errorOrWarningMessage
    assert broken.geometryOrOriginOne is None
    assert cells(broken.geometryOneTransform)[2, 3] == pytest.approx(20.0)
    assert joints.itemByName("old").isSuppressed
