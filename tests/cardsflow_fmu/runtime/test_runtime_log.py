from __future__ import annotations

from pathlib import Path

import pytest
from fmpy import fmi2
from support.fmu.fmu_host import STEP, Host, load, opened, require_error
from toy_model import REFERENCES, ToyModel

pytestmark = pytest.mark.native


def test_fmpy_shows_messages_unchanged(toy_fmu: Path, capfd: pytest.CaptureFixture[str]) -> None:
    slave = load(toy_fmu).slave
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal([REFERENCES["fail_at"]], [0.0])
    slave.exitInitializationMode()
    require_error(lambda: slave.doStep(0.0, STEP))
    slave.freeInstance()
    printed = capfd.readouterr().out
    assert printed.startswith("[ERROR] doStep at 0 s: ValueError: 100 % broken at 0.0 s: größer")
    assert "Traceback" in printed


class MuteError(Exception):
    def __str__() -> str:
        raise RuntimeError


def fail_with(started: Host, error: type[Exception], *arguments: str) -> None:
    """Run a step in which the model raises an error."""

    def fail(self: ToyModel, t: float, h: float) -> None:
        raise error(*arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ToyModel, "step", fail)
        require_error(lambda: started.slave.doStep(0.0, STEP))


def test_long_texts_are_split(started: Host) -> None:
    text = "ü%" * 3000 + "\n" + "line\n" * 1000 + "#"
    fail_with(started, ValueError, text)
    pieces = [message.text for message in started.messages]
    assert all(len(piece.encode()) <= 2000 for piece in pieces)
    whole = "".join(pieces).replace("%%", "%").replace("##", "#")
    assert text.replace("\n", "") in whole.replace("\n", "")


def test_texts_that_c_cannot_represent_are_escaped(started: Host) -> None:
    fail_with(started, ValueError, "nul \0 surrogate \ud800 end")
    assert r"nul \0 surrogate \ud800 end" in started.last


def test_exceptions_without_a_text(started: Host) -> None:
    fail_with(started, MuteError)
    assert "MuteError" in started.last


def test_events_are_logged_on_request(toy_fmu: Path) -> None:
    with opened(toy_fmu, events=True) as (host,):
        host.start()
        host.slave.terminate()
        host.slave.reset()
        assert [(message.category, message.text) for message in host.messages] == [
            ("logEvents", "instantiated"),
            ("logEvents", "initialized"),
            ("logEvents", "terminated"),
            ("logEvents", "reset"),
        ]


@pytest.mark.parametrize(
    ("is_on", "categories", "expected"),
    [
        (True, [], 1),
        (True, ["logEvents"], 1),
        (True, ["logStatusError", "logAll"], 1),
        (True, ["logStatusError"], 0),
        (False, ["logEvents"], 0),
    ],
)
def test_categories(host: Host, is_on: bool, categories: list[str], expected: int) -> None:
    host.slave.setDebugLogging(is_on, categories)
    host.start()
    assert len(host.messages) == expected


def test_unknown_category_is_rejected(host: Host) -> None:
    host.slave.setDebugLogging(True, ["logNonsense"])
    assert host.messages[-1].category == "logStatusWarning"


def test_no_logger(toy_fmu: Path) -> None:
    host = load(toy_fmu)
    host.callbacks = fmi2.fmi2CallbackFunctions()
    assert host.instantiate("wrong", "file:///nowhere") is None
    assert host.instantiate(host.slave.guid, (toy_fmu / "resources").as_uri())
    require_error(lambda: host.slave.doStep(0.0, STEP))
    host.slave.freeInstance()
