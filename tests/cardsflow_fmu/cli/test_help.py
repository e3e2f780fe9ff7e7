"""Help texts, suggestions for mistyped words, renamed options, colours, `--quiet`."""

from __future__ import annotations

import argparse
import io
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu.cli.main import COMMANDS, _parser
from cardsflow_fmu.cli.terminal.messages import print_error, print_note, quiet_messages
from cardsflow_fmu.cli.terminal.streams import PrintableStream

ROBOT = PLANAR_2R / "robot"


def parsers(
    parser: argparse.ArgumentParser, name: str = ""
) -> Iterator[tuple[str, argparse.Action]]:
    """Yield every argument of every command, with the command."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, inner in action.choices.items():
                yield from parsers(inner, f"{name} {word}".strip())
        elif not isinstance(action, argparse._HelpAction | argparse._VersionAction):
            yield name, action


ARGUMENTS = list(parsers(_parser()))
OPTIONS = [
    (name, action) for name, action in ARGUMENTS if action.option_strings or action.nargs == "?"
]


def test_every_option_states_its_default() -> None:
    for name, action in OPTIONS:
        text = (action.help or "") % vars(action)
        stated = re.search(r"\((default: .+|required.*)\)$", text, re.DOTALL)
        assert stated, f"{name} {action.option_strings}: {text}"
        if action.required:
            assert stated[1] == "required"
        elif isinstance(action.default, int | float | str | Path) and action.nargs != 0:
            assert str(action.default) in stated[1] or f"{action.default:g}" in stated[1], text


def test_help_texts_have_no_full_stop_and_no_initial_capital() -> None:
    for name, action in ARGUMENTS:
        text = action.help or ""
        assert text, (name, action)
        assert not text.endswith("."), text
        assert text[0] == text[0].lower() or text.startswith(("JSON", "FMI")), text


def test_shared_options_have_the_same_form() -> None:
    forms: dict[str, set[tuple[object, ...]]] = {}
    for _, action in OPTIONS:
        for option in action.option_strings:
            form = (type(action), action.type, action.dest)
            forms.setdefault(option, set()).add(form)
    del forms["--motion"]  # in `check`, it is also the name of a trajectory
    several = {option: found for option, found in forms.items() if len(found) > 1}
    assert not several


def test_help_groups_all_commands_by_task(cardsflow: CommandLine) -> None:
    code, out, _ = cardsflow("--help")
    assert code == 0
    places = [out.index(f"\n{title}:\n") for title in COMMANDS]
    assert places == sorted(places)
    commands = {name.split()[0] for name, _ in ARGUMENTS}
    listed = set(re.findall(r"^  ([a-z-]+) ", out[places[0] : out.index("\nOptions:")], re.M))
    assert listed == commands


# Suggestions


@pytest.mark.parametrize(
    ("words", "suggestion"),
    [
        (("rnu",), "run"),
        (("chek", ROBOT), "check"),
        (("import_cad", "a.json"), "import-cad"),
        (("reprot",), "report"),
        (("addin", "instal"), "install"),
        (("run", PLANAR_2R, "--realtme"), "--realtime"),
        (("run", "--outptu", "there", PLANAR_2R), "--output"),
        (("convert", ROBOT, "--too", "mjcf"), "--to"),
        (("compare", "a", "b", "--rtl=1"), "--rtol"),
        (("excite", ROBOT, "--speeed", "1"), "--speed"),
        (("run", PLANAR_2R, "--coupling", "dirct"), "direct"),
        (("completion", "basj"), "bash"),
        (("schema", "experimnt"), "experiment"),
    ],
)
def test_mistyped_word_has_a_suggestion_and_usage(
    words: tuple[object, ...], suggestion: str, cardsflow: CommandLine
) -> None:
    code, out, err = cardsflow(*words)
    assert (code, out) == (2, "")
    *usage, line = err.splitlines()
    assert f"did you mean '{suggestion}'?" in line
    command = [] if len(words) == 1 or words[0] in ("chek", "import_cad") else [str(words[0])]
    assert usage[0].startswith(" ".join(["usage: cardsflow", *command]))


@pytest.mark.parametrize(
    ("words", "suggestion"),
    [
        (("run", EXAMPLES / "planr_2r"), "planar_2r"),
        (("check", PLANAR_2R / "robt"), "robot"),
        (("info", ROBOT / "planar_2r_bodies.xmk"), "planar_2r_bodies.xml"),
        (("study", EXAMPLES / "design_study/atachments.toml"), "attachments.toml"),
        (("plot", EXAMPLES / "planar_2R"), "planar_2r"),
        (("run", PLANAR_2R, "--set", "controler.kp=1"), "controller"),
        (("check", ROBOT, "--cable-set", "basc"), "basic"),
        (("convert", ROBOT, "--to", "mjfc", "-o", "there"), "mjcf"),
    ],
)
def test_mistyped_file_key_or_name_has_a_suggestion(
    words: tuple[object, ...], suggestion: str, cardsflow: CommandLine
) -> None:
    line = cardsflow.error_line(*words)
    assert re.search(rf"did you mean '([^']*/)?{re.escape(suggestion)}'\?", line), line


def test_options_cannot_be_abbreviated(cardsflow: CommandLine) -> None:
    code, _, err = cardsflow("run", PLANAR_2R, "--real")
    assert code == 2
    assert "unknown option '--real'; did you mean '--realtime'?" in err


# Colours and `--quiet`


class Terminal(io.StringIO):
    """Stream that is a terminal."""

    def isatty(self) -> bool:
        return True


def print_messages(stream: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(sys, "stderr", PrintableStream(stream, is_needed=False))
    print_error("a.toml: \x1b[2J wrong")
    print_note("warning: doubtful")
    return stream.getvalue()


def test_colours_are_only_used_on_terminals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    plain = "cardsflow: a.toml: \\x1b[2J wrong\ncardsflow: warning: doubtful\n"
    assert print_messages(io.StringIO(), monkeypatch) == plain
    coloured = print_messages(Terminal(), monkeypatch)
    assert "\x1b[1;31mcardsflow: \x1b[0ma.toml: \\x1b[2J" in coloured
    assert "\x1b[1;33mwarning:\x1b[0m doubtful" in coloured
    monkeypatch.setenv("NO_COLOR", "1")
    assert print_messages(Terminal(), monkeypatch) == plain


def test_quiet_suppresses_warnings_but_not_errors(capsys: pytest.CaptureFixture[str]) -> None:
    with quiet_messages(True):
        print_note("warning: doubtful")
        print_error("wrong")
    assert capsys.readouterr().err == "cardsflow: wrong\n"


def test_every_command_has_quiet() -> None:
    commands = {name for name, _ in ARGUMENTS}
    assert commands == {name for name, action in OPTIONS if "--quiet" in action.option_strings}


def test_quiet_init_prints_only_the_result(tmp_path: Path, cardsflow: CommandLine) -> None:
    file = tmp_path / "experiment.toml"
    code, out, err = cardsflow("init", ROBOT, "-o", file, "--quiet")
    assert (code, err) == (0, "")
    assert out.startswith(f"{file}\n")


# Overwriting


def test_init_overwrites_only_on_request(tmp_path: Path, cardsflow: CommandLine) -> None:
    file = tmp_path / "experiment.toml"
    file.write_text("mine")
    line = cardsflow.error_line("init", ROBOT, "-o", file)
    assert "already exists; choose another file with -o, or use --overwrite" in line
    assert file.read_text() == "mine"
    assert cardsflow("init", ROBOT, "-o", file, "--overwrite")[0] == 0
    assert "[robot]" in file.read_text()
