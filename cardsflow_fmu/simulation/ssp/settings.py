"""Settings of a run of a system: step, duration and coupling scheme."""

from __future__ import annotations

from typing import Annotated

from cardsflow_fmu.cosim.coupling import Scheme
from cardsflow_fmu.experiment.config.table import Listed, Positive, Table, setting
from cardsflow_fmu.experiment.settings.run import Accept


class SystemRunSettings(Table):
    """Step, duration and coupling scheme of a system."""

    step: Positive = setting("communication step, in s")
    duration: Positive = setting("duration, in s")
    scheme: Scheme = setting("coupling scheme: order in which components compute a step")
    accept: Accept = setting("runs that succeed, see run.accept of an experiment", "tracked")
    order: Annotated[tuple[str, ...], Listed] = setting("order of the components", None)
