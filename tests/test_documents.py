"""README, docs and examples name what exists: files, anchors, commands, options, settings."""

from __future__ import annotations

import argparse
import importlib.util
import json
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lxml import etree
from support import documents
from support.documents import ROOT, Block, all_documents, anchors, blocks, inline_code, links

from addin_sdfusion.robot import check, read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.cli.main import _parser

EXPERIMENT_TABLES = {
    "robot",
    "robots",
    "start",
    "reference",
    "controller",
    "plant",
    "run",
    "muscles",
}
MAX_NOT_RUN = 13
"""Blocks that no test runs; fewer are better."""

every_document = pytest.mark.parametrize(
    "file", all_documents(), ids=lambda file: file.relative_to(ROOT).as_posix()
)


@every_document
def test_links_and_pictures_lead_somewhere(file: Path) -> None:
    lost = []
    for line, target in links(file):
        if re.match(r"https?://", target):
            continue
        path, _, anchor = target.partition("#")
        there = (file.parent / path).resolve() if path else file
        outside = ROOT.resolve() not in (there, *there.parents)
        if outside or not there.exists() or (anchor and anchor not in anchors(there)):
            lost.append(f"{file.relative_to(ROOT)}:{line}: {target}")
    assert lost == []


@every_document
def test_files_that_are_named_exist(file: Path) -> None:
    """`sim_dart/csrc/core.h` and the like; `*` matches any."""
    tops = "addin_sdfusion|cardsflow_fmu|controllers|sim_dart|tests|examples|docs|\\.ci"
    lost = [
        f"{file.relative_to(ROOT)}:{line}: {code}"
        for line, code in inline_code(file)
        if re.fullmatch(rf"(?:{tops})/[\w./*\-]+", code)
        and "/results" not in code
        and not any(ROOT.glob(code.rstrip("/")))
    ]
    assert lost == []


@pytest.mark.slow
@every_document
def test_commands_are_understood(file: Path) -> None:
    """Every command that is named exists, and has the options that it is named with."""
    known = _known_commands()
    lines = [(f"{file.name}:{line}", code) for line, code in inline_code(file)]
    for block in blocks(file):
        if block.language in ("sh", "bash", "text"):
            whole = re.sub(r"\\\n\s*", " ", block.text)
            lines += [(str(block), line) for line in whole.splitlines()]
    wrong = []
    for place, line in lines:
        line = re.sub(r"^(uv run |\.venv/bin/|-m |pip .*|.*&& )", "", line.strip())
        if not line.startswith("cardsflow ") or re.match(r"cardsflow[ ]--", line):
            continue
        words = line.split("#")[0].replace("[", " ").replace("]", " ").split()
        is_group = words[1] in ("addin", "policy") and len(words) > 2
        depth = 3 if is_group else 2
        parser = known.get(" ".join(words[:depth]))
        if parser is None:
            wrong.append(f"{place}: {line}")
            continue
        options = {word for action in parser._actions for word in action.option_strings}
        given = {word.split("=")[0] for word in words[depth:] if re.match(r"--?[a-z]", word)}
        wrong += [f"{place}: {line}: {word}" for word in given - options]
    assert wrong == []


def test_commands_in_blocks_parse() -> None:
    """Every `cardsflow` line that a reader may copy, and the experiments that they name exist."""
    lines = []
    for file in all_documents():
        for block in blocks(file):
            if block.language in ("sh", "bash"):
                whole = re.sub(r"\\\n\s*", " ", block.text)
                found = re.findall(r"^(?:uv run )?cardsflow (\w[^\n]*)", whole, re.MULTILINE)
                lines += [(block, line) for line in found]
    assert len(lines) >= 30
    for block, line in lines:
        words = shlex.split(line, comments=True)
        ends = [k for k, word in enumerate(words) if word in (">", "|")]
        options = _parser(words[0]).parse_args(words[: ends[0]] if ends else words)
        named = str(getattr(options, "experiment", ""))
        there = ROOT / named / "experiment.toml"
        assert not named.startswith("examples") or there.is_file(), f"{block}: {line}"


@cache
def _known_commands() -> dict[str, argparse.ArgumentParser]:
    return dict(_commands("cardsflow", _parser()))


def _commands(prefix: str, parser: argparse.ArgumentParser) -> Any:
    yield prefix, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, child in action.choices.items():
                yield from _commands(f"{prefix} {name}", child)


def test_every_command_has_an_example_that_parses() -> None:
    for name, parser in _commands("cardsflow", _parser()):
        if any(isinstance(a, argparse._SubParsersAction) for a in parser._actions):
            continue
        assert parser.epilog, name
        example = parser.epilog.split("\n", 1)[1].strip()
        words = shlex.split(re.split(r"[>|]", example)[0])
        assert _parser(words[1]).parse_args(words[1:]), example


TOML = [block for file in all_documents() for block in blocks(file) if block.language == "toml"]


@pytest.fixture(scope="module")
def experiments(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The examples, to be changed."""
    folder = tmp_path_factory.mktemp("documents") / "examples"
    shutil.copytree(ROOT / "examples", folder, ignore=shutil.ignore_patterns("results", "*.png"))
    return folder


@pytest.mark.parametrize("block", TOML, ids=str)
def test_settings_are_read(block: Block, experiments: Path) -> None:
    """Tables of an experiment are read, in the place of those of the example in the note."""
    data = tomllib.loads(block.text)
    assert data
    if block.argument(documents.NOT_RUN) is not None:
        return
    example = block.argument(documents.PART_OF)
    if example is None:
        hint = f"<!-- {documents.PART_OF}examples/... -->"
        assert not EXPERIMENT_TABLES & set(data), f"{block}: of which example? {hint}"
        return
    folder = experiments.parent / example
    whole = tomllib.loads((folder / "experiment.toml").read_text(encoding="utf-8"))
    if "robots" in data:
        del whole["robot"]
    (folder / "changed.json").write_text(json.dumps(whole | data))
    Experiment.load(folder / "changed.json")


@pytest.mark.parametrize("language", ["xml", "json"])
def test_other_code_is_well_formed(language: str) -> None:
    for file in all_documents():
        for block in blocks(file):
            if block.language == language:
                read = json.loads if language == "json" else etree.fromstring
                assert read(block.text) is not None, block


def test_notes_to_tests_are_understood_and_few_blocks_are_not_run() -> None:
    names = [name for name in dir(documents) if name.isupper() and name != "ROOT"]
    words = [getattr(documents, name) for name in names]
    not_run = []
    for file in documents.documents():
        for block in blocks(file):
            note = block.note
            runs = block.language in ("sh", "bash", "python", "diff")
            assert not (runs and note) or any(note.startswith(word) for word in words), block
            reason = block.argument(documents.NOT_RUN)
            assert reason is None or len(reason) > 8, block
            not_run += [] if reason is None else [block]
    assert len(not_run) <= MAX_NOT_RUN, "\n".join(map(str, not_run))


GENERATED = (
    *(f"reference/{name}.md" for name in ("commands", "ports", "laws", "experiments", "robots")),
    "reference/snapshot.md",
    "how_to/studies.md",
    "explanation/security.md",
)


@pytest.mark.parametrize("page", GENERATED)
def test_generated_tables_match_the_code(page: str) -> None:
    """If this fails: python docs/make_tables.py."""
    spec = importlib.util.spec_from_file_location("make_tables", ROOT / "docs/make_tables.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["make_tables"] = module
    spec.loader.exec_module(module)
    assert (ROOT / "docs" / page).read_text(encoding="utf-8") == module.PAGES[page]()


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """docs/ as pages, with warnings as errors and nothing of earlier builds."""
    pytest.importorskip("sphinx", reason="needs the dependency group `docs`")
    folder = tmp_path_factory.mktemp("pages")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q"]
    done = subprocess.run(
        [*command, "-d", str(folder / "tree"), str(ROOT / "docs"), str(folder / "html")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "html"


@pytest.mark.slow
def test_pages_are_made_and_load_nothing_from_elsewhere(pages: Path) -> None:
    made = sorted(pages.rglob("*.html"))
    sources = {file.relative_to(ROOT / "docs") for file in documents.pages()}
    assert {file.with_suffix("") for file in sources} <= {
        page.relative_to(pages).with_suffix("") for page in made
    }
    loads = re.compile(
        r"<(?:script|img|iframe|source)[^>]+src=\"(?:https?:)?//|@import|url\(\W?http"
        r"|<link[^>]+rel=\"(?:stylesheet|preload)\"[^>]+href=\"(?:https?:)?//"
    )
    for page in made:
        assert loads.search(page.read_text(encoding="utf-8")) is None, page


@pytest.mark.browser
def test_pages_are_read_without_a_network(pages: Path, tmp_path: Path) -> None:
    from support.browser import opened_browser

    with opened_browser(tmp_path) as page:
        for name in ("index", "explanation/equations", "reference/api"):
            page.open((pages / f"{name}.html").as_uri(), offline=True)
            page.wait_for("document.readyState === 'complete' && document.querySelector('h1')")
        page.open((pages / "explanation/equations.html").as_uri(), offline=True)
        page.wait_for("document.readyState === 'complete' && document.querySelector('math')")
        formula = page.evaluate("document.querySelector('math').getBoundingClientRect().width")
        assert formula > 20
        assert page.errors == []
        assert {url.split(":")[0] for url in page.requests} <= {"file", "data", "about"}


def test_the_robot_of_the_words_is_one(tmp_path: Path) -> None:
    """The SDF and the cardsflow.xml of docs/reference/robots.md, side by side."""
    page = ROOT / "docs/reference/robots.md"
    texts = [block.text for block in blocks(page) if block.language == "xml"]
    for name, text in zip(("model.sdf", "cardsflow.xml"), texts, strict=True):
        (tmp_path / name).write_text(text, encoding="utf-8")
    robot = read_robot(tmp_path)
    assert [muscle.name for muscle in robot.muscles] == ["biceps", "triceps"]
    assert [finding for finding in check(robot) if finding.is_error] == []
