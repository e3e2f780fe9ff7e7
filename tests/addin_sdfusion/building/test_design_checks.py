"""Tests of findings: each defect of a design has one finding with advice."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from support.designs.small_designs import (
    DesignSnapshot,
    arm,
    body,
    box,
    group,
    muscles,
    part,
    revolute,
    rigid,
    via,
)

from addin_sdfusion.building.build_robot import build_robot, check_design
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import (
    CouplingSnapshot,
    GroupSnapshot,
    JointSnapshot,
    MotionSnapshot,
    MuscleSnapshot,
    PointSnapshot,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)

ARM = arm()
BASE, UPPER, LOWER = ARM.occurrences
SHOULDER, ELBOW = ARM.joints
Z = (0.0, 0.0, 1.0)


def reported(snapshot: DesignSnapshot) -> list[tuple[str, str, str]]:
    return [(f.severity, f.code, f.subject.name) for f in check_design(snapshot)]


def changed(joint: JointSnapshot, **more: Any) -> DesignSnapshot:
    joints = tuple(replace(j, **more) if j is joint else j for j in ARM.joints)
    return replace(ARM, joints=joints)


def moving(joint: JointSnapshot, **more: Any) -> DesignSnapshot:
    return changed(joint, motions=tuple(replace(m, **more) for m in joint.motions))


def points(*new: Any) -> DesignSnapshot:
    return replace(ARM, points=new)


def with_points(*new: Any) -> DesignSnapshot:
    return replace(ARM, points=(*ARM.points, *new))


def settings(**more: Any) -> DesignSnapshot:
    return replace(ARM, settings=ExportSettings(**more))


def ball(value: float) -> DesignSnapshot:
    axes = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    roles = ("pitch", "yaw", "roll")
    motions = tuple(
        MotionSnapshot("rotation", a, value, role=r) for a, r in zip(axes, roles, strict=True)
    )
    return changed(ELBOW, kind="ball", motions=motions)


def twins(**more: Any) -> DesignSnapshot:
    """Return a finger with two occurrences, each a separate link, with the points of both."""
    fingers = tuple(part(f"finger:{k}") for k in (1, 2))
    both = tuple(
        replace(
            via("flexor", 4, more.get("link", "left"), (0.6, 0.1 * k, 0.0), f"finger:{k}"),
            entity="f",
        )
        for k in (1, 2)
    )
    if "occurrence" in more:
        use = replace(both[0].use, occurrence=more["occurrence"])
        both = tuple(replace(p, use=use) for p in both)
    return replace(
        ARM,
        occurrences=(*ARM.occurrences, *fingers),
        bodies=(*ARM.bodies, body("finger:1"), body("finger:2")),
        groups=(*ARM.groups, group("left", "finger:1"), group("right", "finger:2")),
        joints=(
            *ARM.joints,
            revolute("l", "finger:1", "lower:1"),
            revolute("r", "finger:2", "lower:1"),
        ),
        points=(*ARM.points, *both),
    )


def wrap(link: str = "upper", after: int = 1, **more: Any) -> DesignSnapshot:
    use = SurfaceUse("elbow", link, (WrapUse("flexor", after),))
    given = {"length": 0.1, "use": use, **more}
    surface = SurfaceSnapshot("upper:1", "cylinder", 0.02, (0.4, 0.0, 0.0), **given)
    return replace(ARM, surfaces=(surface,))


def test_a_valid_design_has_no_findings() -> None:
    assert reported(ARM) == []
    assert build_robot(ARM).robot is not None


FIVE = with_points(via("flexor", 5, "lower", (0.6, 0.05, 0.0), "lower:1"))
ORPHAN = replace(ARM, joints=(SHOULDER,))
NO_MASS = tuple(replace(b, mass=None) if b.occurrence == "lower:1" else b for b in ARM.bodies)

CASES = {
    # Links
    "no group, links from groups": (
        replace(settings(links="rigid_groups"), groups=()),
        [("error", "nothing-to-export", "arm")],
    ),
    "an empty design": (DesignSnapshot("arm"), [("error", "nothing-to-export", "arm")]),
    "empty group": (
        replace(ARM, groups=(*ARM.groups, GroupSnapshot("EXPORT_hand", ()))),
        [("warning", "empty-group", "EXPORT_hand")],
    ),
    "suppressed group": (
        replace(ARM, groups=(*ARM.groups, group("hand", "lower:1", suppressed=True))),
        [("warning", "suppressed-group", "EXPORT_hand")],
    ),
    "misspelt group": (
        replace(ARM, groups=(*ARM.groups, GroupSnapshot("Export_hand", ("lower:1",)))),
        [("warning", "misspelt-group", "Export_hand")],
    ),
    "occurrence in two groups": (
        replace(ARM, groups=(*ARM.groups[:2], group("lower", "lower:1", "upper:1"))),
        [("error", "occurrence-in-two-groups", "upper:1")],
    ),
    "two groups of one name": (
        replace(ARM, groups=(*ARM.groups, group("lower", "lower:1"))),
        [("error", "duplicate-link", "EXPORT_lower")],
    ),
    "copied group": (
        replace(
            ARM, groups=(*ARM.groups[:2], group("lower (1)", "lower:1")), points=(), muscles=()
        ),
        [("warning", "copied-name", "EXPORT_lower (1)"), ("warning", "no-muscles", "arm")],
    ),
    "body in no group": (
        replace(
            ARM, bodies=(*ARM.bodies, body("")), occurrences=(*ARM.occurrences, part("screw:1"))
        ),
        [("warning", "body-in-no-link", "arm")],
    ),
    "component in no group": (
        replace(
            ARM,
            bodies=(*ARM.bodies, body("screw:1")),
            occurrences=(*ARM.occurrences, part("screw:1")),
        ),
        [("warning", "body-in-no-link", "screw:1")],
    ),
    "chosen component that is gone": (
        replace(
            settings(links="components", components=("base:1", "uper:1")),
            joints=(),
            points=(),
            muscles=(),
        ),
        [
            ("error", "unknown-component", "uper:1"),
            ("warning", "body-in-no-link", "lower:1"),
            ("warning", "body-in-no-link", "upper:1"),
            ("warning", "no-muscles", "arm"),
        ],
    ),
    "empty component": (
        replace(ARM, groups=(), occurrences=(*ARM.occurrences, part("sketches:1"))),
        [("warning", "empty-component", "sketches")],
    ),
    "bad occurrence": (
        replace(ARM, occurrences=(*ARM.occurrences, part("a:1+b:1", "a:1"))),
        [("error", "bad-occurrence", "a:1+b:1")],
    ),
    # Masses
    "link without mass at the end": (
        replace(ARM, bodies=NO_MASS),
        [
            ("error", "link-without-mass", "lower"),
            ("warning", "no-mass", "lower:1/Body1"),
        ],
    ),
    # Joints
    "suppressed joint": (
        changed(ELBOW, suppressed=True),
        [("error", "link-not-connected", "lower"), ("warning", "suppressed-joint", "elbow")],
    ),
    "broken joint": (
        changed(ELBOW, problem="Reference lost"),
        [("error", "broken-joint", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "inferred joint": (
        changed(ELBOW, kind="inferred", motions=()),
        [("error", "unsupported-joint", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "joint without component": (
        changed(ELBOW, two=None),
        [("error", "joint-without-component", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "joint without origin": (
        changed(ELBOW, origin_one=None, origin_two=None),
        [("error", "joint-without-origin", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "joint without motion": (
        changed(ELBOW, motions=()),
        [("error", "joint-without-motion", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "axis without direction": (
        moving(ELBOW, axis=(0.0, 0.0, 0.0)),
        [("error", "zero-axis", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "value that is not finite": (
        moving(ELBOW, value=float("inf")),
        [("error", "not-finite", "elbow"), ("error", "link-not-connected", "lower")],
    ),
    "link without joint": (ORPHAN, [("error", "link-not-connected", "lower")]),
    "locked joint": (changed(ELBOW, locked=True), [("warning", "locked-joint", "elbow")]),
    "limits 0..0": (moving(ELBOW, lower=0.0, upper=0.0), [("warning", "zero-limits", "elbow")]),
    "equal limits": (
        moving(ELBOW, lower=0.5, upper=0.5, value=0.5),
        [("warning", "zero-limits", "elbow")],
    ),
    "reversed limits": (
        moving(ELBOW, lower=0.5, upper=-0.5),
        [("error", "limits-reversed", "elbow")],
    ),
    "outside its limits": (
        moving(ELBOW, lower=0.5, upper=1.5),
        [("warning", "initial-outside-limits", "elbow")],
    ),
    "turned ball joint": (ball(0.3), [("warning", "ball-joint-turned", "elbow")]),
    "ball joint at home": (ball(0.0), []),
    "sides apart": (
        changed(ELBOW, origin_two=(0.4, 0.01, 0.0)),
        [("warning", "joint-sides-apart", "elbow")],
    ),
    "offset along its axis": (changed(ELBOW, origin_two=(0.4, 0.0, 0.01)), []),
    "joint within a link": (
        replace(
            ARM,
            occurrences=(*ARM.occurrences, part("lower:1+motor:1", "lower:1")),
            joints=(*ARM.joints, revolute("shaft", "lower:1+motor:1", "lower:1")),
        ),
        [("warning", "joint-within-link", "shaft")],
    ),
    "rigid joint within a link": (
        replace(
            ARM,
            occurrences=(*ARM.occurrences, part("lower:1+motor:1", "lower:1")),
            joints=(*ARM.joints, rigid("shaft", "lower:1+motor:1", "lower:1")),
        ),
        [],
    ),
    "joint to a component without link": (
        replace(
            ARM,
            occurrences=(*ARM.occurrences, part("screw:1")),
            joints=(*ARM.joints, rigid("screwed", "screw:1", "lower:1")),
        ),
        [("warning", "joint-outside-links", "screwed")],
    ),
    "two joints with the same name": (
        replace(ARM, joints=(SHOULDER, replace(ELBOW, name="shoulder")), points=(), muscles=()),
        [("error", "duplicate-joint", "shoulder"), ("warning", "no-muscles", "arm")],
    ),
    # Names
    "link and joint with the same name": (
        changed(ELBOW, name="EXPORT_lower"),
        [("error", "name-clash", "lower")],
    ),
    "names that differ by case": (
        changed(ELBOW, name="Shoulder"),
        [("warning", "names-differ-by-case", "Shoulder")],
    ),
    "a name with a line break": (
        changed(ELBOW, name="el\nbow"),
        [("error", "bad-name", "el\nbow")],
    ),
    "no name": (replace(ARM, name=""), [("error", "missing-name", "")]),
    "a link called world": (
        replace(ARM, groups=(*ARM.groups[:2], group("world", "lower:1")), points=(), muscles=()),
        [("error", "reserved-name", "world"), ("warning", "no-muscles", "arm")],
    ),
    # Muscles
    "unknown link": (
        with_points(via("flexor", 4, "Lower", (0.6, 0.0, 0.0))),
        [("error", "unknown-link", "flexor")],
    ),
    "one point": (
        points(ARM.points[0]),
        [("error", "too-few-via-points", "flexor")],
    ),
    "all points on an unknown link": (
        points(via("flexor", 1, "old", (0, 0, 0)), via("flexor", 2, "old", (1, 0, 0))),
        [("error", "unknown-link", "flexor")],
    ),
    "on one link": (
        points(via("flexor", 1, "lower", (0, 0, 0)), via("flexor", 2, "lower", (1, 0, 0))),
        [("warning", "no-moment-arm", "flexor")],
    ),
    "same point twice": (
        with_points(via("flexor", 4, "lower", ARM.points[-1].position)),
        [("error", "zero-length-segment", "flexor")],
    ),
    "two links, one position": (
        with_points(via("flexor", 4, "upper", ARM.points[-1].position)),
        [("warning", "coincident-points", "flexor")],
    ),
    "a missing number": (FIVE, [("warning", "missing-number", "flexor")]),
    "a duplicate number": (
        with_points(replace(via("flexor", 3, "lower", (0.6, 0, 0)), entity="x")),
        [("error", "duplicate-number", "flexor")],
    ),
    "an invalid opacity": (
        replace(ARM, bodies=(replace(ARM.bodies[0], opacity=7.0), *ARM.bodies[1:])),
        [("error", "bad-opacity", "base:1/Body1")],
    ),
    "invalid couplings": (
        replace(
            ARM,
            couplings=(
                CouplingSnapshot("elbow", "shoulder", 2.0),
                CouplingSnapshot("elbow", "shoulder", 3.0),
                CouplingSnapshot("shoulder", "elbow"),
                CouplingSnapshot("wrist", "elbow"),
            ),
        ),
        [("warning", "coupling-left-out", name) for name in ("elbow", "shoulder", "wrist")],
    ),
    "no forces given": (
        replace(ARM, muscles=()),
        [("warning", "default-forces", "flexor")],
    ),
    "reversed forces": (
        replace(ARM, muscles=(MuscleSnapshot("flexor", f_min=9.0, f_max=1.0),)),
        [("error", "force-limits-reversed", "flexor")],
    ),
    "broken point": (
        replace(ARM, points=(replace(ARM.points[0], problem="Lost"), *ARM.points[1:])),
        [("warning", "broken-point", "Pflexor1")],
    ),
    "old centre of mass": (
        with_points(PointSnapshot("COM_lower", "lower:1", (0.0, 0.0, 0.0), "c")),
        [("warning", "com-point-ignored", "COM_lower")],
    ),
    "a component in two links, link given": (twins(), []),
    "a component in two links, neither given": (
        twins(link="lower"),
        [("error", "ambiguous-point", "Pflexor4")],
    ),
    "a component in two links, occurrence given": (twins(link="lower", occurrence="finger:2"), []),
    "task point on an unknown link": (
        with_points(PointSnapshot("EE_hand", "", (0.0, 0.0, 0.0), "e")),
        [("error", "unknown-link", "hand")],
    ),
    "task point on the world": (
        with_points(PointSnapshot("EE_world", "", (0.0, 0.0, 0.0), "e")),
        [("error", "task-point-on-world", "world")],
    ),
    # Wraps
    "wrap": (wrap(), []),
    "wrap on an unknown link": (wrap(link="Upper"), [("error", "unknown-link", "elbow")]),
    "wrap after the last point": (wrap(after=3), [("error", "bad-wrap", "elbow")]),
    "two wraps of one name": (
        replace(wrap(), surfaces=wrap().surfaces * 2),
        [("error", "duplicate-wrap", "elbow")],
    ),
    # The design
    "part": (
        DesignSnapshot("cube", bodies=(body(""),), intent="part"),
        [("warning", "part-design", "cube"), ("warning", "no-muscles", "cube")],
    ),
    "assembly": (
        replace(ARM, intent="assembly", points=(), muscles=()),
        [("warning", "assembly-design", "arm"), ("warning", "no-muscles", "arm")],
    ),
    "an assembly with muscles": (replace(ARM, intent="assembly"), []),
    "y up": (
        replace(
            ARM,
            bodies=tuple(
                body(o.path, box((0.1, 0.1, 0.1), (0, 0.3 * k, 0)))
                for k, o in enumerate(ARM.occurrences)
            ),
        ),
        [("warning", "up-axis", "arm")],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_each_defect_is_reported_once(case: str) -> None:
    snapshot, expected = CASES[case]
    found = reported(snapshot)
    assert sorted(found) == sorted(expected)
    assert [severity for severity, _, _ in found] == sorted(severity for severity, _, _ in found)
    errors = any(severity == "error" for severity, _, _ in found)
    assert (build_robot(snapshot).robot is None) == errors


def test_every_message_is_one_line_with_the_name_of_its_object() -> None:
    for snapshot, _ in CASES.values():
        for finding in check_design(snapshot):
            assert repr(finding.subject.name)[1:-1] in finding.message
            assert "\n" not in finding.message.replace("el\nbow", "")
            assert len(finding.message) > 30


def test_the_nearest_link_name_is_suggested() -> None:
    (finding,) = check_design(CASES["unknown link"][0])
    assert "did you mean 'lower'?" in finding.message
    assert "4" in finding.message


def test_a_point_on_a_suppressed_link_is_reported() -> None:
    snapshot = replace(
        ORPHAN,
        groups=(*ARM.groups[:2], replace(ARM.groups[2], suppressed=True)),
        bodies=ARM.bodies[:2],
    )
    finding = next(f for f in check_design(snapshot) if f.code == "unknown-link")
    assert "suppressed" in finding.message


def test_findings_of_the_reader_are_kept() -> None:
    finding = check_design(ORPHAN)[0]
    assert finding in check_design(replace(ARM, findings=(finding,)))
    assert build_robot(replace(ARM, findings=(finding,))).robot is None


def test_all_defects_are_reported_at_once() -> None:
    snapshot = replace(
        ARM,
        joints=(SHOULDER, replace(ELBOW, problem="Lost")),
        points=(*ARM.points[:2], via("flexor", 3, "hand", (0, 0, 0))),
        bodies=(*NO_MASS, body("")),
        muscles=muscles("flexor", "extensor"),
    )
    assert {code for _, code, _ in reported(snapshot)} == {
        "broken-joint",
        "link-not-connected",
        "unknown-link",
        "too-few-via-points",
        "link-without-mass",
        "no-mass",
        "body-in-no-link",
    }
