from __future__ import annotations

import math

import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Conversion, Unit, conversion

CELSIUS = Unit("degC", KNOWN_UNITS["m"].exponents, 1.0, 273.15)
FAHRENHEIT = Unit("degF", KNOWN_UNITS["m"].exponents, 5 / 9, 273.15 - 32 * 5 / 9)


@pytest.mark.parametrize(
    ("source", "target", "value", "expected"),
    [
        ("deg", "rad", 180.0, math.pi),
        ("rad", "deg", math.pi, 180.0),
        ("kN", "N", 0.25, 250.0),
        ("mm", "cm", 10.0, 1.0),
        ("deg/s", "rad/s", 90.0, math.pi / 2),
        ("N.mm", "kN.m", 1e6, 1.0),
    ],
)
def test_values_are_converted_to_another_unit(
    source: str, target: str, value: float, expected: float
) -> None:
    change = conversion(KNOWN_UNITS[source], KNOWN_UNITS[target])
    assert change.factor * value + change.offset == pytest.approx(expected, rel=1e-15)


def test_offsets_of_units_are_applied() -> None:
    change = conversion(CELSIUS, FAHRENHEIT)
    assert change.factor * 100.0 + change.offset == pytest.approx(212.0)
    assert conversion(FAHRENHEIT, CELSIUS).offset == pytest.approx(-32 * 5 / 9)


def test_equal_units_need_no_conversion() -> None:
    assert conversion(KNOWN_UNITS["N"], KNOWN_UNITS["N"]) == Conversion()
    assert conversion(None, None).is_identity
    assert conversion(Unit("brightness", None), Unit("brightness", None)).is_identity


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        (
            KNOWN_UNITS["deg"],
            KNOWN_UNITS["N"],
            "'deg' is not compatible with 'N': rad is not kg.m.s-2",
        ),
        (
            None,
            KNOWN_UNITS["rad"],
            "no unit is not compatible with 'rad'; specify the missing unit",
        ),
        (
            KNOWN_UNITS["rad"],
            None,
            "'rad' is not compatible with no unit; specify the missing unit",
        ),
        (Unit("a", None), Unit("b", None), "'a' is not compatible with 'b'"),
        (Unit("a", None), KNOWN_UNITS["N"], "an undefined unit is not kg.m.s-2"),
    ],
)
def test_incompatible_units_are_rejected(
    source: Unit | None, target: Unit | None, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        conversion(source, target)
    assert message in str(caught.value)


@pytest.mark.parametrize("wrong", [(0.0, 0.0), (math.nan, 0.0), (1.0, math.inf)])
def test_units_with_an_invalid_factor_are_rejected(wrong: tuple[float, float]) -> None:
    flat = Unit("flat", KNOWN_UNITS["m"].exponents, *wrong)
    for pair in ((flat, KNOWN_UNITS["m"]), (KNOWN_UNITS["m"], flat)):
        with pytest.raises(InputError, match="'flat' has the invalid factor"):
            conversion(*pair)
