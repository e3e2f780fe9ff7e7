from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.muscles.point_names import (
    PointName,
    is_point_name,
    marker_name,
    motor_numbers,
    natural_key,
    parse_point_name,
    task_point_name,
    via_point_name,
)

links = st.text("abz_019 Äß-.", min_size=1, max_size=12)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("VP_motor0_EXPORT_arm_3", PointName("via", "arm", 0, 3)),
        ("VP_motor12_EXPORT_upper_arm_l_10", PointName("via", "upper_arm_l", 12, 10)),
        ("VP_motor0_EXPORT_a_0_3", PointName("via", "a_0", 0, 3)),
        ("VP_motor0_EXPORT_a_0 (1)", PointName("via", "a", 0, 0, 1)),
        ("VP_motor0_EXPORT_a_0(2)", PointName("via", "a", 0, 0, 2)),
        ("VP_motor0_EXPORT_?_0", PointName("via", "?", 0, 0)),
        ("VP_motor007_EXPORT_link_EXPORT_2_9", PointName("via", "link_EXPORT_2", 7, 9)),
        ("EE_hand", PointName("task", "hand")),
        ("EE_hand (1)", PointName("task", "hand", copy=1)),
        ("EE_EXPORT_hand", PointName("task", "hand")),
        ("VM_hand_2", PointName("marker", "hand_2")),
        ("COM_torso", PointName("com", "torso")),
    ],
)
def test_names_specify_the_use_of_a_point(name: str, expected: PointName) -> None:
    assert parse_point_name(name) == expected


@pytest.mark.parametrize(
    "name",
    ["", "Point1", "VP_", "VP_motor_EXPORT_a_0", "VP_motor0_a_0", "VP_motor0_EXPORT_a", "EE_",
     "vp_motor0_EXPORT_a_0", "VP_motor0_EXPORT__", "VP_motor0_EXPORT_a_1.5",
     "VP_motor0_EXPORT_a_9999999999"],
)  # fmt: skip
def test_other_names_are_not_parsed(name: str) -> None:
    assert parse_point_name(name) is None


def test_malformed_names_are_recognised() -> None:
    assert is_point_name("VP_motor0_arm")
    assert not is_point_name("Point1")


@given(st.integers(0, 999_999_999), links, st.integers(0, 999_999_999))
def test_via_points_keep_link_and_numbers(motor: int, link: str, number: int) -> None:
    parsed = parse_point_name(via_point_name(motor, link, number))
    assert parsed == PointName("via", link, motor, number)
    assert parsed.muscle == f"motor{motor}"


@given(st.from_regex(r"[a-z0-9_]{1,9}", fullmatch=True))
def test_task_points_and_markers_keep_the_link(link: str) -> None:
    for name, role in ((task_point_name(link), "task"), (marker_name(link), "marker")):
        parsed = parse_point_name(name)
        assert parsed is not None
        assert parsed.role == role
        assert parsed.link == link.removeprefix("EXPORT_")
        assert parsed.muscle == ""


@given(st.lists(st.sampled_from(["motor0", "motor1", "motor5", "biceps", "motor05", "x", "ü"])))
def test_every_muscle_has_a_unique_number(muscles: list[str]) -> None:
    numbers = motor_numbers(muscles)
    assert numbers.keys() == set(muscles)
    assert len(set(numbers.values())) == len(numbers)
    for name in ("motor0", "motor1", "motor5"):
        assert numbers.get(name, int(name[5:])) == int(name[5:])


def test_numbers_compare_as_numbers() -> None:
    names = ["motor10", "motor2", "motor", "Motor1", "motor2b", "2", "10"]
    assert sorted(names, key=natural_key) == [
        "Motor1", "motor", "motor2", "motor2b", "motor10", "2", "10",
    ]  # fmt: skip


def test_very_long_numbers_are_compared() -> None:
    names = ["m" + "9" * 5000, "m1" + "0" * 5000, "m007", "m8"]
    assert sorted(names, key=natural_key) == ["m007", "m8", names[0], names[1]]
