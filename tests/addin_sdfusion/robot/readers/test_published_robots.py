from __future__ import annotations

import pytest

from addin_sdfusion.robot import CardsflowError, Robot, read_robot
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.read import read

CASPR = ("BMArm", "Example_2R_planar_XZ", "Example_planar_XY", "Example_spatial")
CASPR += ("Example_spherical", "RoboyLeftArm", "RoboyUpperBody")
CARDSFLOW = ("VRpuppet", "exosuit", "msj_platform", "musc-le", "roboy_icecream")
CARDSFLOW += ("roboy_upper_body", "test_robot")
PUBLISHED = [f"caspr/{name}" for name in CASPR] + [f"cardsflow/{name}" for name in CARDSFLOW]


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_robot_is_read_or_its_defects_are_reported(shared, name):
    try:
        reading = read(shared / "robots" / name)
    except CardsflowError as error:
        pytest.fail(f"not even read: {error}")
    assert isinstance(reading.robot, Robot) or any(f.is_error for f in reading.findings)
    assert all(f.file is not None and "\n" not in str(f) for f in reading.findings)


GEN_A = {"inertia-about-origin", "inertia-xz-yz-swapped"}
GEN_B = {"inertia-about-origin"}
DEFECTS = {
    "VRpuppet": GEN_B | {"locked-by-limits", "shared-name"},
    "exosuit": GEN_B | {"link-name-case"},
    "msj_platform": GEN_A | {"inertia-triangle"},
    "musc-le": {"kinematic-link"},
    "roboy_icecream": GEN_B
    | {"duplicate-link", "several-roots", "no-moment-arm", "locked-by-limits"},
    "roboy_upper_body": GEN_A | {"inertia-triangle"},
    "test_robot": GEN_A,
}
EVERYWHERE = {"welded-root", "no-force-limit", "missing-meshes"}
"""All are written for Gazebo, without force limits, and only some of their meshes exist."""


@pytest.mark.parametrize("name", DEFECTS)
def test_published_robot_has_exactly_its_known_defects(shared, name):
    findings = read(shared / "robots/cardsflow" / name).findings
    codes = {finding.code for finding in findings}
    everywhere = EVERYWHERE
    if name == "exosuit":  # all of its meshes exist
        everywhere = {"welded-root", "no-force-limit"}
    assert codes == DEFECTS[name] | everywhere
    assert all(finding.line is not None for finding in findings)


def named(findings, code):
    return sorted(finding.subject.name for finding in findings if finding.code == code)


def test_findings_name_the_affected_object(shared):
    cardsflow = shared / "robots/cardsflow"
    icecream = read(cardsflow / "roboy_icecream").findings
    assert named(icecream, "duplicate-link") == ["scooper_2"]
    assert named(icecream, "no-moment-arm") == ["motor25", "motor26", "motor27"]
    assert named(icecream, "locked-by-limits") == ["elbow_left", "spine"]
    roots = ["scooper_2", "scooper_link0", "scooper_link1", "torso"]
    assert named(icecream, "welded-root") == roots
    sliders = named(read(cardsflow / "VRpuppet").findings, "locked-by-limits")
    assert sliders == [f"motor{k}" for k in range(6)]
    exosuit = [f for f in read(cardsflow / "exosuit").findings if f.code == "link-name-case"]
    assert {(f.file.name, f.line) for f in exosuit} >= {("cardsflow.xml", 7)}
    assert "unknown link 'upperArm'; link 'upperarm' is used instead" in exosuit[0].message


def test_joint_with_the_name_of_its_link_is_renamed_in_sdf(shared, tmp_path):
    """The joint is renamed as in libsdformat; its coordinate keeps the name."""
    reading = read(shared / "robots/cardsflow/VRpuppet")
    shared_names = [f"motor{k}" for k in range(6)]
    assert named(reading.findings, "shared-name") == shared_names
    robot = reading.require()
    conversion = convert(robot, "sdf", tmp_path)
    assert named(conversion.findings, "joint-renamed") == shared_names
    again = read_robot(tmp_path)
    assert {f"{name}_joint" for name in shared_names} <= {joint.name for joint in again.joints}
    assert again.coordinates == robot.coordinates
    assert again.muscles == robot.muscles
