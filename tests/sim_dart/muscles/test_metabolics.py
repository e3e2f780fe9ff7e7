"""Metabolic rates against OpenSim."""

from __future__ import annotations

import numpy as np
import pytest

from sim_dart.muscles.metabolics import FibreStates, bhargava_2004, umberger_2010

ROWS = np.array(
    [
        "798.52",
        "0.134",
        "10",
        "0.5",
        "0.3",
        "1.24104079014",
        "-0.0075872033015",
        "0.890295966399",
        "202.68016303",
        "59.4071568987",
        "32.7710665569",
        "27.2662295341",
        "435.56",
        "0.1321",
        "10",
        "0.3",
        "0.4",
        "0.935039254051",
        "0.0835792370289",
        "0.991595718075",
        "249.438546991",
        "0",
        "0",
        "0",
        "987.26",
        "0.0858",
        "10",
        "0.25",
        "0.5",
        "0.935383368983",
        "0.0287316402882",
        "0.991684151553",
        "633.352865035",
        "0",
        "4.83604353241",
        "0",
        "798.52",
        "0.134",
        "10",
        "0.2",
        "0.6",
        "1.28667974884",
        "-0.0323666336661",
        "0.848427573022",
        "351.980605451",
        "85.8317363675",
        "29.6010559468",
        "21.3497788454",
        "435.56",
        "0.1321",
        "10",
        "0",
        "0.7",
        "0.702914393427",
        "-0.188780220886",
        "0.838182254007",
        "129.087519871",
        "0",
        "30.8417918835",
        "30.4614631437",
        "798.52",
        "0.134",
        "10",
        "0.9",
        "0.05",
        "1.35481002081",
        "0.150582057767",
        "0.777415516146",
        "51.1265101011",
        "143.743012077",
        "99.4074998432",
        "41.2506553362",
        "435.56",
        "0.1321",
        "10",
        "0.7",
        "0.15",
        "1.17467060028",
        "-0.134115198252",
        "0.940804764817",
        "22.8859726738",
        "17.9124246363",
        "31.1398079191",
        "28.4966977175",
        "987.26",
        "0.0858",
        "10",
        "0.65",
        "0.25",
        "1.00336250926",
        "-0.0785754072363",
        "0.999977387319",
        "114.94388332",
        "0.417571447993",
        "48.0202652415",
        "50.2206174565",
    ],
    dtype=float,
).reshape(8, 12)
"""States of muscles of arm26.osim (slow fibres: 0.4), and the results of the probes
Umberger2010MuscleMetabolicsProbe and Bhargava2004MuscleMetabolicsProbe of OpenSim 4.6."""


def test_rates_match_the_probes_of_opensim() -> None:
    states = FibreStates(*ROWS.T[:10], slow=0.4)
    np.testing.assert_allclose(umberger_2010(states), ROWS[:, 10], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(bhargava_2004(states), ROWS[:, 11], rtol=1e-9, atol=1e-9)


def test_isometric_rate_in_closed_form() -> None:
    """At the optimal length and at rest, only the heat of activation and maintenance remains."""
    one = np.ones(1)
    own = FibreStates(
        *(1000.0 * one, 0.1 * one, 10.0 * one, one, one, one, 0 * one, one, 1000 * one, 0 * one)
    )
    mass = 1000.0 / 0.25e6 * 1059.7 * 0.1
    assert own.mass == pytest.approx(mass)
    assert umberger_2010(own) == pytest.approx(1.5 * (128.0 * 0.5 + 25.0) * mass)
    assert bhargava_2004(own) == pytest.approx(0.5 * (40.0 + 133.0 + 74.0 + 111.0) * mass)
