"""Phrases and names that plain English replaces do not return: in Python, C and Markdown."""

from __future__ import annotations

import argparse
import io
import re
import tokenize
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from support import documents
from support.documents import ROOT

from cardsflow_fmu.cli.main import _parser

PHRASES = (
    r"\bby the clock\b",
    # quotes of texts that had to be rewritten
    r"errors' 2-norm",
    r"\btrial of it\b",
    r"\blacks up to\b",
    r"\bpoints whose motion counts\b",
    r"\bmakes a shell complete\b",
    r"\bnothing of nothing\b",
    r"\bthe folder free\b",
    r"\bwhere silent\b",
    r"\breadings surprise\b",
    r"\bof several the last\b",
    r"\bno recording of it will tell\b",
    r"\bone's own\b",
    r"\bof a robot of which\b",
    r"\bso many at the end\b",
    r"\bwithout what starts\b",
    r"\bas one knows who\b",
    r"\bnearly none\b",
    # inversions and archaic words
    r"\bwherein\b",
    r"\bwhereof\b",
    r"\bhitherto\b",
    r"\bof whom\b",
    r"\bwhen left out\b",
    r"\bas it stands\b",
    r"\bthat is told\b",
    # metaphors and personification
    r"\bforeign (?:file|FMU|robot)s?\b",
    r"\bgoes safe\b",
    r"\bthe ground of all\b",
    r"\bnothing pulls\b",
    r"\bwhere a folder is to be\b",
    r"\bof now\b",
    r"\bwhere left out\b",
    r"\bfrom there on\b",
    r"\bto and fro\b",
    r"\bwhat is left of it\b",
    r"\b(?:file|robot|experiment|design|code|table|plant|controller)s? (?:says?|knows?|speaks?)\b",
    r"\binertial units?\b",
    r"\b(?:cables?|joints?|robots?) (?:that )?rubs?\b",
    r"\bis no number\b",
    r"(?-i:(?<!there )\bis none\b)",
    r"\bleft out\b",
    r"\bkept out\b",
    r"\btension laws?\b",
)
"""Regular expressions of phrases that must not return; each begins at a word."""

PHRASE = re.compile(
    r"\b(?:" + "|".join(phrase.removeprefix(r"\b") for phrase in PHRASES) + ")", re.IGNORECASE
)

IN_LOWER_CASE = re.compile(PHRASE.pattern.lower())
"""The same for text in lower case, which is several times faster."""

NAME = re.compile(
    r"\b_?(?:MOST|LEAST|LARGEST|SMALLEST|LONGEST|SHORTEST|FEWEST|HIGHEST|FARTHEST|DEEPEST"
    r"|HEAVIEST|LIGHTEST|GREATEST)(?:_\w+)?\b"
)
"""Constants of limits, which begin with `MAX_` or `MIN_`."""

HEAD = re.compile(r"^For .{10,}? (?:At the end|You find|This page)", re.DOTALL)
"""Head of a page: who needs it, and what they find or have at its end."""

FOLDERS = (
    "addin_sdfusion",
    "cardsflow_fmu",
    "controllers",
    "sim_dart",
    "docs",
    "examples",
    "tests",
)


def python_texts(text: str) -> Iterator[tuple[int, str]]:
    """Yield line number and text of each line of a comment, docstring or string."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        kind = tokenize.tok_name[token.type]
        if kind in ("COMMENT", "STRING", "FSTRING_MIDDLE"):
            for k, line in enumerate(token.string.split("\n")):
                yield token.start[0] + k, line


def c_texts(text: str) -> Iterator[tuple[int, str]]:
    """Yield line number and text of each line of a comment or string."""
    for match in re.finditer(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', text, re.DOTALL):
        first = text.count("\n", 0, match.start()) + 1
        for k, line in enumerate(match[0].split("\n")):
            yield first + k, line


def plain_texts(text: str) -> Iterator[tuple[int, str]]:
    """Yield line number and text of all lines."""
    yield from enumerate(text.split("\n"), 1)


READERS: dict[str, Callable[[str], Iterator[tuple[int, str]]]] = {
    ".py": python_texts,
    ".c": c_texts,
    ".h": c_texts,
    ".md": plain_texts,
    ".toml": plain_texts,
}


def files(folder: Path) -> list[Path]:
    """Return the files of a folder whose texts are checked."""
    skipped = {"_build", "__pycache__", "results", "generated"}
    return [
        file
        for file in sorted(folder.rglob("*"))
        if file.suffix in READERS
        and not skipped & set(file.relative_to(ROOT).parts)
        and file != Path(__file__)
    ]


def found(file: Path) -> list[str]:
    """Return the phrases of a file that must not return, with their lines."""
    text = file.read_text(encoding="utf-8")
    if not IN_LOWER_CASE.search(text.replace("is None", "").lower()):
        return []
    return [
        f"{file}:{line}: {match[0]!r} in {part.strip()[:120]!r}"
        for line, part in READERS[file.suffix](text)
        for match in [PHRASE.search(part)]
        if match
    ]


@pytest.mark.parametrize("folder", FOLDERS)
def test_texts_are_plain_english(folder: str) -> None:
    assert [hit for file in files(ROOT / folder) for hit in found(file)] == []


def test_documents_at_the_top_are_plain_english() -> None:
    top = [ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CONTRIBUTING", "SECURITY")]
    assert [hit for file in top for hit in found(file)] == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_limits_are_named_max_or_min(folder: str) -> None:
    hits = []
    for file in files(ROOT / folder):
        if file.suffix in (".py", ".c", ".h"):
            text = file.read_text(encoding="utf-8")
            hits += [f"{file}: {match[0]}" for match in NAME.finditer(text)]
    assert hits == []


def test_pages_start_with_who_needs_them() -> None:
    without = []
    for page in documents.pages():
        text = re.sub(r"<!--.*?-->", "", page.read_text(encoding="utf-8"))
        body = text.strip().partition("\n")[2].strip()
        without += [] if HEAD.match(body.partition("\n\n")[0]) else [str(page)]
    assert without == []


def _options(parser: argparse.ArgumentParser, name: str) -> Iterator[tuple[str, argparse.Action]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, child in action.choices.items():
                yield from _options(child, f"{name} {word}")
        elif action.option_strings and action.nargs != 0 and action.help != argparse.SUPPRESS:
            yield name, action


def test_help_of_options_states_the_default() -> None:
    """Options with a value state `(default: ...)` or `(required)`; some may be repeated."""
    wrong = [
        f"{name} {action.option_strings[0]}: {action.help}"
        for name, action in _options(_parser(), "cardsflow")
        if not re.search(r"\(default: |\(required|; default: ", action.help or "")
    ]
    assert wrong == []


SEARCH_WORDS = (
    "end effector",
    "tendon-driven",
    "antagonist",
    "co-contraction",
    "routing",
    "IMU",
    "ground truth",
    "emergency stop",
    "interactive",
    "waypoint",
)


@pytest.mark.parametrize("word", SEARCH_WORDS)
def test_terms_of_the_field_are_explained_in_the_glossary(word: str) -> None:
    pages = [page.read_text(encoding="utf-8").lower() for page in documents.pages()]
    assert sum(word.lower() in text for text in pages) >= 2
    assert word.lower() in (ROOT / "docs/glossary.md").read_text(encoding="utf-8").lower()


@pytest.mark.parametrize(
    "phrase",
    [
        "RMS of the errors' 2-norm",
        "a trial of it tracks",
        "let steps wait by the clock",
        "its unit is none",
        "nothing pulls elbow down",
    ],
)
def test_old_phrases_are_found(phrase: str, tmp_path: Path) -> None:
    for name, text in (
        ("text.py", f'"""{phrase}."""\n'),
        ("text.c", f"/* {phrase} */\n"),
        ("text.md", f"{phrase}\n"),
    ):
        file = tmp_path / name
        file.write_text(text, encoding="utf-8")
        assert len(found(file)) == 1, name
