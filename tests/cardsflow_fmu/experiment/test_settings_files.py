"""Files of settings by others: what they may not be made of."""

from __future__ import annotations

from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError
from cardsflow_fmu.config.file import read_settings


@pytest.mark.parametrize(
    ("text", "is_too_deep"),
    [
        (".".join(["a"] * 51) + " = 1", True),
        (".".join(["a"] * 20_000) + " = 1", True),
        ("[" + " . ".join(["a", "'b.c'", '"d"'] * 70_000) + "]", True),
        ("a = " + "[" * 200 + "]" * 200, True),
        ("a = " + "{b = " * 60 + "1" + "}" * 60, True),
        ("[" + ".".join("a" * 30) + "]\n" + ".".join("b" * 30) + " = 1", True),
        (".".join(["a"] * 40) + " = 1", False),
        ("a = [" + "0.5, " * 10_000 + "]", False),
        ("a = '" + "/x.y/" * 10_000 + "'", False),
    ],
    ids=range(9),
)
def test_settings_are_not_nested_without_end(text: str, is_too_deep: bool, tmp_path: Path) -> None:
    """Tomllib takes minutes for a header of 200000 names; what it gives ended the recursion."""
    file = tmp_path / "experiment.toml"
    file.write_text(text)
    if not is_too_deep:
        assert "a" in read_settings(file)
        return
    with pytest.raises(InputError, match=r"experiment\.toml: is nested too deeply"):
        read_settings(file)
