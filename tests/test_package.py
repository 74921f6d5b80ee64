"""The Python package works on its own: it is built from the sources into a wheel, can be imported without the packages
that the command line needs, and reports missing parts clearly."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from simulation import REPOSITORY

PYTHON = REPOSITORY / ".venv" / "bin" / "python"
COMMAND_LINE_PACKAGES = ("typer", "rich", "mcap", "matplotlib", "click")


def python(code: str, path: Path | None = None, **environment: str) -> subprocess.CompletedProcess:
    variables = {"PATH": os.environ["PATH"], **environment} | ({"PYTHONPATH": str(path)} if path else {})
    return subprocess.run([PYTHON, "-c", code], capture_output=True, text=True, check=False, env=variables, cwd="/")


def without(*names: str) -> str:
    """Returns Python code that makes the named modules impossible to import."""
    return f"import sys; sys.modules.update(dict.fromkeys({names!r})); "


@pytest.fixture(scope="module")
def clone(tmp_path_factory) -> Path:
    """Copies the part of the repository that the package needs, without build products."""
    folder = tmp_path_factory.mktemp("clone")
    ignored = shutil.ignore_patterns("*.so", "__pycache__", "build", "*.egg-info")
    for name in ("firmware", "host_tools"):
        shutil.copytree(REPOSITORY / name, folder / name, ignore=ignored)
    return folder


def install(clone: Path, target: Path, **environment: str) -> Path:
    """Installs the package as pip and pipx do, but offline, so that its requirements come from this environment."""
    command = [
        PYTHON,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--no-build-isolation",
        "--no-index",
        "--target",
        target,
        clone / "host_tools",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ | environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return target


@pytest.fixture(scope="module")
def installed(clone, tmp_path_factory) -> Path:
    return install(clone, tmp_path_factory.mktemp("installed"))


def test_the_installed_package_has_the_core_of_these_sources(installed):
    done = python(
        "from comanip import core, native; import comanip; ffi, lib = native.load(); "
        "print(comanip.__file__, f'{lib.replay_build_hash():016x}', len(core.arms()))",
        installed,
    )
    assert done.returncode == 0, done.stderr
    place, build_hash, arms = done.stdout.split()
    assert Path(place).is_relative_to(installed)
    assert build_hash in (REPOSITORY / "build" / "generated" / "comanip_identity.h").read_text()
    assert int(arms) >= 1


def test_the_installed_package_has_the_command(installed):
    script = installed / "bin" / "comanip"
    done = subprocess.run(
        [PYTHON, script, "doctor"],
        capture_output=True,
        text=True,
        check=False,
        cwd="/",
        env={"PYTHONPATH": str(installed), "PATH": "/usr/bin:/bin"},
    )
    assert done.returncode == 0, done.stderr
    assert "compiled core" in done.stdout
    assert {path.name for path in (installed / "comanip" / "commands").glob("*.py")} >= {"replay.py", "monitor.py"}


def test_the_installed_package_has_no_developer_tools(installed):
    assert [path for path in installed.rglob("*") if path.name.startswith(("comanip_dev", "development"))] == []
    names = {path.stem for path in (installed / "comanip").rglob("*.py")}
    assert names >= {"frame", "replay", "transport"} and not names & {
        "codegen",
        "build_core",
        "campaign",
        "gain_search",
    }
    code = "import sys; sys.path = [p for p in sys.path if 'host_tools' not in p]; import comanip.campaign"
    done = python(code, installed)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("ModuleNotFoundError: comanip.campaign is now comanip_dev.")
    assert "clone of the repository" in done.stderr.splitlines()[-1]


def test_without_a_compiler_it_installs_and_reports_what_is_missing(clone, tmp_path):
    target = install(clone, tmp_path / "target", CC="no-such-compiler")
    assert not list(target.rglob("_core*.so"))
    log = tmp_path / "bus.log"
    log.write_text("(1.000000) vcan0 701##105\n")
    run = "import sys; sys.argv = ['comanip', {!r}, {!r}]; from comanip.__main__ import main; main()"
    decoded = python(run.format("decode", str(log)), target)
    assert "FirmwareHeartbeat" in decoded.stdout, decoded.stderr
    replayed = python(run.format("replay", str(log)), target)
    assert replayed.returncode == 2
    assert replayed.stderr.startswith("comanip: ") and replayed.stderr.count("\n") == 1
    assert "make build" in replayed.stderr and "pipx install" in replayed.stderr


def test_core_imports_without_the_packages_of_the_command_line():
    done = python(
        without(*COMMAND_LINE_PACKAGES) + "from comanip import core, frame, logs, replay, pcap; print(len(core.arms()))"
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("missing", ["typer", "rich"])
def test_command_without_its_packages_reports_it(missing):
    done = python(without(missing) + "from comanip.__main__ import main; main()")
    assert done.returncode == 2
    assert done.stderr.startswith(f"comanip: the package {missing} is missing") and done.stderr.count("\n") == 1


def test_installed_versions_meet_the_packages_requirements():
    """The packages installed here meet the requirements in pyproject.toml, as judged by pip itself."""
    import tomllib

    from packaging.requirements import Requirement

    project = tomllib.loads((REPOSITORY / "host_tools" / "pyproject.toml").read_text())
    lines = (REPOSITORY / "host_tools" / "requirements.txt").read_text().splitlines()
    pinned = dict(line.lower().split("==") for line in lines if "==" in line)
    for text in project["project"]["dependencies"]:
        requirement = Requirement(text)
        assert requirement.specifier.contains(pinned[requirement.name.lower()]), text
    for text in project["build-system"]["requires"]:
        requirement = Requirement(text)
        if requirement.name != "setuptools":
            assert requirement.specifier.contains(pinned[requirement.name]), text
