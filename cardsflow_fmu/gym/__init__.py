"""Environments of Gymnasium: robots that reinforcement learning trains; needs the extra `gym`.

Importing this module registers the environments `cardsflow/...`.
"""

from __future__ import annotations

from addin_sdfusion.robot import CardsflowError

try:
    import gymnasium  # noqa: F401
except ImportError as error:
    raise CardsflowError(
        "environments need the package gymnasium; install cardsflow[gymnasium]"
    ) from error

from .env import CardsflowEnv
from .experiments import from_experiment
from .registry import register_environments
from .vector_env import CardsflowVectorEnv

__all__ = ["CardsflowEnv", "CardsflowVectorEnv", "from_experiment"]

register_environments()
