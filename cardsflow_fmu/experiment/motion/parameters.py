"""Settings of [[motion.parameters]]: numbers of the robot that the optimisation chooses."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import FromZero, Table, Text, setting


def _numbers(value: Any) -> tuple[float, ...]:
    """Return a number or a vector as a tuple."""
    values = value if isinstance(value, list | tuple) else [value]
    is_number = [isinstance(k, int | float) and not isinstance(k, bool) for k in values]
    if not values or not all(is_number):
        raise SettingError(f"must be a number, or a list of numbers, not {value!r}")
    try:
        return tuple(map(float, values))
    except OverflowError:
        raise SettingError("must be finite") from None


Numbers = Annotated[
    tuple[Annotated[float, Field(allow_inf_nan=False)], ...],
    BeforeValidator(_numbers),
    WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "array", "items": {"type": "number"}}]}),
]


class ParameterSettings(Table):
    """Number or vector of the robot that the optimisation chooses within bounds."""

    path: Text = setting(
        "full key of a number or vector: a via point, a number of a muscle law or of a wrap "
        "surface, a mass, or a spring of a joint, such as robot.muscles.biceps.points[1].position"
    )
    low: Numbers = setting(
        "smallest value; a number, or one number per element of the vector", alias="from"
    )
    high: Numbers = setting("largest value; an element with equal values is constant", alias="to")
    weight: FromZero = setting("weight of the squared change from the value of the robot", 0.0)

    @model_validator(mode="after")
    def _check_bounds(self) -> Self:
        if len(self.low) != len(self.high):
            problem = f"must have {len(self.low)} numbers, like from, not {len(self.high)}"
            raise SettingError(problem, key="to")
        pairs = list(zip(self.low, self.high, strict=True))
        for low, high in pairs:
            if low > high:
                raise SettingError(f"must be at least from, {low!r}, not {high!r}", key="to")
        if all(low == high for low, high in pairs):
            raise SettingError("must be above from", key="to")
        return self
