"""The folders of the Python packages import only from permitted folders, the installed package contains no developer
tools, and former names are not used."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import pytest
from simulation import REPOSITORY

PACKAGES = {
    "comanip": REPOSITORY / "host_tools" / "comanip",
    "comanip_dev": REPOSITORY / "host_tools" / "development" / "comanip_dev",
}
# Each folder may use itself and those listed before it.
ROOMS = (
    "_former_names", "errors", "parameters", "tasks", "_core", "native",
    "bus", "core", "tracker", "replay", "plotting", "commands", "cli",
)  # fmt: skip


def modules(package: str) -> dict[str, Path]:
    folder = PACKAGES[package]
    found = {}
    for path in folder.rglob("*.py"):
        parts = (package, *path.relative_to(folder).with_suffix("").parts)
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = {name: path for package in PACKAGES for name, path in modules(package).items()}


def imported(path: Path) -> set[str]:
    """Returns the modules of comanip and comanip_dev that a file imports, including imports inside functions. `from
    package import module` counts as importing the module."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: relative import"
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            inner = {name for name in names if name in MODULES or name == "comanip._core"}
            found |= inner | ({node.module} if len(inner) < len(names) else set())
    return {name for name in found if name.split(".")[0] in PACKAGES}


def test_the_installed_package_uses_no_developer_tools():
    users = [name for name in modules("comanip") if any(m.startswith("comanip_dev") for m in imported(MODULES[name]))]
    assert users == []


def test_folders_use_only_those_before_them():
    users = {name: path for name, path in modules("comanip").items() if name not in ("comanip", "comanip.__main__")}
    assert {name.split(".")[1] for name in users} <= set(ROOMS), "a new folder: add it to ROOMS"
    wrong = []
    for name, path in users.items():
        within = ("comanip", *(f"comanip.{room}" for room in ROOMS[: ROOMS.index(name.split(".")[1]) + 1]))
        wrong += [f"{name} uses {other}" for other in imported(path) if ".".join(other.split(".")[:2]) not in within]
    assert wrong == []


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_imports_itself_through_others(package):
    graphlib.TopologicalSorter({name: imported(MODULES[name]) - {package} for name in modules(package)}).prepare()


def python(code: str, *options: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, *options, "-c", code], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("old", "new", "name"),
    [
        ("comanip.arm", "comanip.core.arm", "Arm"),
        ("comanip.bus", "comanip.bus.live", "open_bus"),
        ("comanip.bus_state", "comanip.bus.state", "BusState"),
        ("comanip.calibration", "comanip.tracker.calibration", "solve"),
        ("comanip.cooperation", "comanip.core.cooperation", "Cooperation"),
        ("comanip.frame", "comanip.bus.frame", "Frame"),
        ("comanip.frame_length", "comanip.bus.frame_length", "longest"),
        ("comanip.logs", "comanip.bus.logs", "read"),
        ("comanip.mcap_log", "comanip.bus.mcap_log", "write"),
        ("comanip.operator_client", "comanip.bus.operator_client", "OperatorClient"),
        ("comanip.pcap", "comanip.bus.pcap", "write"),
        ("comanip.plot", "comanip.plotting.__main__", "draw"),
        ("comanip.pose_lines", "comanip.tracker.pose_lines", "parse"),
        ("comanip.tracker_publisher", "comanip.tracker.publisher", "TrackerPublisher"),
        ("comanip.transport", "comanip.bus.transport", "Profile"),
        ("comanip.following.one", "comanip_dev.following.one", "main"),
    ],
)
def test_former_name_gives_the_same_and_warns(old, new, name):
    code = (
        f"from {old} import {name} as former; from {new} import {name} as now; print(former.__name__ == now.__name__)"
    )
    done = python(code, "-W", "always")
    assert done.stdout == "True\n", done.stderr
    assert "DeprecationWarning" in done.stderr and new.removesuffix(".one") in done.stderr


def test_new_names_do_not_warn():
    done = python("import comanip.commands, comanip.cli, comanip_dev.following.one", "-W", "error::DeprecationWarning")
    assert (done.returncode, done.stderr) == (0, "")


def test_former_program_runs_and_names_its_successor():
    done = subprocess.run(
        [sys.executable, "-m", "comanip.following", "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert done.stdout.startswith("usage: comanip_dev.following")
    assert done.stderr == (
        "comanip.following is now comanip_dev.following; the old name will be removed in the next release\n"
    )
