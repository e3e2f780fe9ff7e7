"""Environments of Gymnasium for reinforcement learning; needs the extra `gymnasium`.

Importing this module registers the environments `cardsflow/...`.
"""

from __future__ import annotations

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.extras import install

try:
    import gymnasium  # noqa: F401
except ImportError:
    raise InputError(f"environments need gymnasium: {install('gymnasium')}") from None

from .env import CardsflowEnv
from .experiments import from_experiment
from .registry import register_environments
from .vector_env import CardsflowVectorEnv

__all__ = ["CardsflowEnv", "CardsflowVectorEnv", "from_experiment"]

register_environments()
