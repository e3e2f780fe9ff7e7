"""The tables of what each format holds."""

from __future__ import annotations

import pytest

from addin_sdfusion.robot.formats import features
from addin_sdfusion.robot.formats.capability import Capabilities, Feature
from addin_sdfusion.robot.formats.cardsflow.capabilities import CARDSFLOW
from addin_sdfusion.robot.formats.caspr.capabilities import CASPR
from addin_sdfusion.robot.formats.mjcf.capabilities import MJCF
from addin_sdfusion.robot.formats.opensim.capabilities import OPENSIM
from addin_sdfusion.robot.formats.sdf.capabilities import SDF
from addin_sdfusion.robot.formats.urdf.capabilities import URDF

TABLES = [SDF, CARDSFLOW, CASPR, URDF, MJCF, OPENSIM]


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.title)
def test_every_feature_has_a_row(table: Capabilities) -> None:
    features_of_robots = [f for f in vars(features).values() if isinstance(f, Feature)]
    assert len(features_of_robots) > 30
    listed = {feature.name for row in table.rows for feature in row.features}
    assert [f.name for f in features_of_robots if f.name not in listed] == []


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.title)
def test_every_loss_has_a_code_and_a_message(table: Capabilities) -> None:
    lost = [row for row in table.rows if row.fate in ("changed", "refused")]
    assert lost
    assert all(row.code and row.message for row in lost)
    assert not any(row.code for row in table.rows if row.fate == "kept")
