"""Calls of the command line `cardsflow` in the process of the tests."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from cardsflow_fmu.cli.main import main


class CommandLine:
    """Command line that captures the output of its commands."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys

    def __call__(self, *words: object) -> tuple[int, str, str]:
        """Run a command; return its exit code, output and messages."""
        self._capsys.readouterr()
        try:
            code = main(list(map(str, words)))
        except SystemExit as end:
            code = int(end.code or 0)
        return code, *self._capsys.readouterr()

    def error_line(self, *words: object, code: int = 2) -> str:
        """Run a command that must fail without output; return its message of one line."""
        found, out, err = self(*words)
        assert (found, out) == (code, ""), err
        err = re.sub(r"cardsflow: \w+: \d+ s elapsed\n", "", err)  # progress on a busy machine
        assert err.startswith("cardsflow: ")
        assert err.count("\n") == 1, err
        return err

    def json(self, *words: object) -> Any:
        """Run a command with `--json`; return its output."""
        code, out, err = self(*words, "--json")
        assert code == 0, err
        return json.loads(out)
