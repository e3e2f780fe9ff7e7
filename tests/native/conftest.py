"""Core and laws compiled with numbers of single and of double precision."""

from __future__ import annotations

import pytest
from support.native.precision import Precision


@pytest.fixture(scope="session")
def single(tmp_path_factory: pytest.TempPathFactory) -> Precision:
    return Precision(tmp_path_factory.mktemp("single"), True)


@pytest.fixture(scope="session")
def double(tmp_path_factory: pytest.TempPathFactory) -> Precision:
    return Precision(tmp_path_factory.mktemp("double"), False)
