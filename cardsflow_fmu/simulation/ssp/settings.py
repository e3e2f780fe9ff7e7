"""Settings for the run of a system: step, duration and coupling scheme."""

from __future__ import annotations

from typing import Annotated

from cardsflow_fmu.cosim.coupling import Scheme
from cardsflow_fmu.experiment.config.table import Listed, Positive, Table, setting


class SystemRunSettings(Table):
    """The co-simulation of a system."""

    step: Positive = setting("communication step, in s")
    duration: Positive = setting("in s")
    scheme: Scheme = setting("in what order components are stepped")
    order: Annotated[tuple[str, ...], Listed] = setting("of the components", None)
