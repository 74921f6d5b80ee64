"""Checks that everything the README and docs/ refer to exists: files and folders, functions, make targets, and commands
of comanip."""

from __future__ import annotations

import fnmatch
import re
import subprocess
from functools import cache
from pathlib import Path

import pytest
import typer
from comanip.cli import app
from simulation import REPOSITORY

DOCUMENTS = sorted([*REPOSITORY.glob("*.md"), *REPOSITORY.glob("docs/*.md")])
# The changelog is left out, as it refers to files and commands of earlier versions.
NAMES = [path.relative_to(REPOSITORY).as_posix() for path in DOCUMENTS if path.name != "CHANGELOG.md"]

FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"^ {4}\S.*$", re.MULTILINE)
SPAN = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\]\(([^)#:]+)\)")
DOCUMENT = re.compile(r"(?<![\w/`])docs/[\w-]+\.md")
SOURCE = re.compile(r"[\w*./-]+\.(?:[chS]|py|mk|toml|yaml|ld|dbc|sh)")
PLACEHOLDER = "NAME"  # as in hal/NAME/ and tests/test_NAME.py
FUNCTION = re.compile(r"([a-z_][a-z0-9_]+)\(\)")
MAKE = re.compile(r"(?<![\w./-])make((?: [a-z][a-z-]*(?![\w=./-]))+)")
COMANIP = re.compile(r"(?<!from )(?<![\w./-])comanip ([a-z]+)(?: ([a-z]+))?")


@cache
def files() -> frozenset[str]:
    """Returns all files in the repository, including new ones that are not ignored, because a document may refer to a
    file that is committed together with the document."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listing = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True)
    return frozenset(name for name in listing.stdout.splitlines() if (REPOSITORY / name).exists())


@cache
def folders() -> frozenset[str]:
    return frozenset("/".join(name.split("/")[:depth]) for name in files() for depth in range(1, name.count("/") + 1))


@cache
def functions() -> frozenset[str]:
    """Returns every name followed by '(' in the repository's C and Python sources, except this file."""
    names = (name for name in files() if name.endswith((".c", ".h", ".py", ".hpp", ".cpp")))
    sources = (REPOSITORY / name for name in names if (REPOSITORY / name) != Path(__file__))
    return frozenset(name for path in sources for name in re.findall(r"(\w+)\(", path.read_text()))


@cache
def make_targets() -> frozenset[str]:
    """Returns all targets that make itself lists in its database."""
    database = subprocess.run(["make", "-pq", "help"], cwd=REPOSITORY, capture_output=True, text=True, check=False)
    return frozenset(re.findall(r"^([a-z][\w-]*):", database.stdout, re.MULTILINE))


@cache
def commands() -> dict[str, frozenset[str]]:
    """Returns the commands of comanip, each with its subcommands."""
    group = typer.main.get_command(app)
    return {name: frozenset(getattr(command, "commands", {})) for name, command in group.commands.items()}


def code_of(text: str) -> list[str]:
    """Returns the code of a document: fenced and indented lines without their comments, and code spans in all other
    lines."""
    blocks = [line.partition("#")[0] for fence in FENCE.findall(text) for line in fence.splitlines()]
    rest = FENCE.sub("", text)
    blocks += INDENTED.findall(rest)
    return blocks + SPAN.findall(INDENTED.sub("", rest))


def exists(path: str) -> bool:
    """Returns whether the repository contains a path. The path is relative to the root or is the end of a longer path.
    * and NAME match any name."""
    pattern = path.replace(PLACEHOLDER, "*").rstrip("/")
    rooted = pattern.split("/")[0] in {name.split("/")[0] for name in files()}
    patterns = [pattern] if rooted and "/" in pattern else [pattern, f"*/{pattern}"]
    return any(fnmatch.filter(files() | folders(), each) for each in patterns)


def paths_in(text: str) -> set[str]:
    tops = {name.split("/")[0] for name in files() if "/" in name}
    spans = {span for span in SPAN.findall(FENCE.sub("", text)) if " " not in span and "{" not in span}
    rooted = {span for span in spans if span.split("/")[0] in tops and "/" in span}
    links = {target if target.startswith("docs/") else f"docs/{target}" for target in LINK.findall(text)}
    return rooted | {span for span in spans if SOURCE.fullmatch(span)} | set(DOCUMENT.findall(text)) | links


def missing_paths(text: str) -> set[str]:
    return {path for path in paths_in(text) if not path.startswith(("build/", "out/")) and not exists(path)}


def missing_functions(text: str) -> set[str]:
    return {name for code in code_of(text) for name in FUNCTION.findall(code) if name not in functions()}


def missing_targets(text: str) -> set[str]:
    named = {word for code in code_of(text) for words in MAKE.findall(code) for word in words.split()}
    return named - make_targets()


def missing_commands(text: str) -> set[str]:
    named = [match for code in code_of(text) for match in COMANIP.findall(code)]
    return {
        f"{name} {sub}".strip()
        for name, sub in named
        if name not in commands() or (commands()[name] and sub and sub not in commands()[name])
    }


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("missing", [missing_paths, missing_functions, missing_targets, missing_commands])
def test_what_is_named_exists(name, missing):
    assert missing((REPOSITORY / name).read_text()) == set()


def test_what_is_missing_is_found():
    """Each check can fail: it reports names that do not exist."""
    assert missing_paths("`firmware/no_such.c`, `no_such.c`, `hal/linux/`, docs/no_such.md, [x](bus.md)") == {
        "firmware/no_such.c",
        "no_such.c",
        "docs/no_such.md",
    }
    assert missing_functions("`no_such_function()` and `controller_step()`") == {"no_such_function"}
    assert missing_targets("```sh\nmake sim no-such # make neither\n```\n`make test`") == {"no-such"}
    assert missing_commands("`comanip monitor`, `comanip nosuch`, `comanip task nosuch`") == {"nosuch", "task nosuch"}


def test_something_is_named_in_each_kind():
    """Each pattern finds something in the README. If a pattern never matched, every document would pass."""
    text = (REPOSITORY / "README.md").read_text()
    assert len(paths_in(text)) > 10
    assert {"sim", "test", "target"} <= make_targets()
    assert {"monitor", "param"} <= commands().keys()
    assert {"sim", "test", "bus-report"} <= {
        w for code in code_of(text) for ws in MAKE.findall(code) for w in ws.split()
    }
