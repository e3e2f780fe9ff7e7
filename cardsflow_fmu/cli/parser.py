"""Argument parser with suggestions for mistyped words, and commands grouped by task."""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from .terminal.messages import print_error

BAD_INPUT = 2
EXIT_CODES = """exit codes:
  0    success
  1    failure, or a negative result: reference not followed, errors found, results differ,
       muscles too weak
  2    invalid input or options; nothing was done
  3    success with warnings, if `--strict` was given
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); a run keeps its results so far"""


class Parser(argparse.ArgumentParser):
    """Parser of a command.

    For an unknown option or value, it suggests the most similar one. Usage errors include the usage
    of the command. Options cannot be abbreviated.
    """

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **options)
        self.command_groups: dict[str, list[str]] = {}

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse words; an unknown word is an error with the usage of this command."""
        words = list(sys.argv[1:] if args is None else args)
        self._check_options(words)
        parsed, unknown = super().parse_known_args(words, namespace)
        if unknown:
            self.error(f"unexpected argument {unknown[0]!r}")
        return parsed, unknown

    def error(self, message: str) -> NoReturn:
        """Print the usage and a message; exit with 2."""
        self.print_usage(sys.stderr)
        print_error(message, f"{self.prog}: error: ")
        raise SystemExit(BAD_INPUT)

    def format_help(self) -> str:
        """Return the help text, with the commands in groups if there are any."""
        if not self.command_groups:
            return super().format_help()
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, self._actions, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        (commands,) = (a for a in self._actions if isinstance(a, argparse._SubParsersAction))
        choices = {choice.dest: choice for choice in commands._choices_actions}
        for title, names in self.command_groups.items():
            formatter.start_section(title)
            formatter.add_arguments([choices[name] for name in names])
            formatter.end_section()
        formatter.start_section("Options")
        formatter.add_arguments([a for a in self._actions if a is not commands])
        formatter.end_section()
        formatter.add_text(self.epilog)
        return formatter.format_help()

    def _check_options(self, words: Sequence[str]) -> None:
        """Reject unknown long options, before missing arguments are reported."""
        has_commands = self._subparsers is not None
        for word in words:
            if word == "--" or (has_commands and not word.startswith("-")):
                return
            option = word.partition("=")[0]
            if not word.startswith("--") or " " in option or option in self._option_string_actions:
                continue
            nearest = difflib.get_close_matches(option, self._shown_options(), n=1, cutoff=0.6)
            hint = f"did you mean {nearest[0]!r}?" if nearest else f"`{self.prog} --help` lists all"
            self.error(f"unknown option {option!r}; {hint}")

    def _shown_options(self) -> list[str]:
        shown = [action for action in self._actions if action.help != argparse.SUPPRESS]
        return [option for action in shown for option in action.option_strings]

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Reject a value that is not one of the choices of an argument."""
        if action.choices is None or value in action.choices:
            return
        from addin_sdfusion.robot import UnknownNameError

        is_command = isinstance(action, argparse._SubParsersAction)
        kind = "command" if is_command else "value"
        problem = UnknownNameError(kind, str(value), map(str, action.choices)).problem
        if is_command:
            self.error(problem)
        raise argparse.ArgumentError(action, problem)


class Commands:
    """The commands below a parser."""

    def __init__(self, parser: Parser, metavar: str) -> None:
        self._parser = parser
        self._parsers = parser.add_subparsers(metavar=metavar, required=True)
        self._common = Parser(add_help=False)
        text = "do not print progress, notes and warnings (default: off)"
        self._common.add_argument("-q", "--quiet", action="store_true", help=text)
        self._common.add_argument(
            "--debug", action="store_true", help="print the traceback of an error (default: off)"
        )

    def start_group(self, title: str) -> None:
        """Start a group of commands in the help text."""
        self._parser.command_groups[title] = []

    def add(
        self,
        name: str,
        run: Callable[[argparse.Namespace], int],
        text: str,
        example: str,
        details: str = "",
    ) -> Parser:
        """Add a command and return its parser.

        Args:
            run: Function of the parsed options that returns the exit code.
            text: One sentence that describes the command.
            example: A command line.
            details: Additional sentences for the help text of the command.
        """
        description = f"{text} {details}".strip()
        parser = self._add(name, text, example, description=description, parents=[self._common])
        parser.set_defaults(command=run)
        return parser

    def group(self, name: str, text: str, example: str) -> Commands:
        """Add a command with actions; the arguments are as for `add`."""
        return Commands(self._add(name, text, example, description=text), "ACTION")

    def _add(self, name: str, text: str, example: str, **options: Any) -> Parser:
        groups = self._parser.command_groups
        if groups:
            groups[list(groups)[-1]].append(name)
        parser: Parser = self._parsers.add_parser(
            name, help=text, epilog=f"example:\n  {example}", **options
        )
        return parser
