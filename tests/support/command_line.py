"""The command line `cardsflow` in the tests' process."""

from __future__ import annotations

import json
from typing import Any

import pytest

from cardsflow_fmu.cli.main import main


class CommandLine:
    """Runs commands, and captures what they print."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def __call__(self, *words: object) -> tuple[int, str, str]:
        """Exit code, output and messages of a command."""
        self._capsys.readouterr()
        try:
            code = main(list(map(str, words)))
        except SystemExit as end:
            code = int(end.code or 0)
        return code, *self._capsys.readouterr()

    def refused(self, *words: object, code: int = 2) -> str:
        """The one line of a command that fails with an exit code and no output."""
        found, out, err = self(*words)
        assert (found, out) == (code, ""), err
        assert err.startswith("cardsflow: ")
        assert err.count("\n") == 1
        return err

    def json(self, *words: object) -> Any:
        """The output of a command with `--json`."""
        code, out, err = self(*words, "--json")
        assert code == 0, err
        return json.loads(out)
