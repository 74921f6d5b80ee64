"""A port to a board with a CAN controller needs nothing but its own folder: tests/skeleton_port is added under hal/ in
an otherwise unchanged copy of the repository."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest
from comanip_dev.images import stack_report
from images import REPOSITORY, make
from simulation import PATIENCE_S

SHARED = {"hal/cortex_m", "hal/common"}


def make_in(tree, *arguments: str):
    # -o deps keeps make from installing packages, because the repository's environment is complete
    return make("-C", str(tree), "-o", "deps", *arguments)


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    root = tmp_path_factory.mktemp("tree")
    for name in ("Makefile", "firmware", "host_tools", "sim", "tests", ".venv"):
        (root / name).symlink_to(REPOSITORY / name)
    (root / "hal").mkdir()
    for path in (REPOSITORY / "hal").iterdir():
        (root / "hal" / path.name).symlink_to(path)
    shutil.copytree(REPOSITORY / "tests/skeleton_port", root / "hal/skeleton")
    return root


@pytest.fixture(scope="module")
def built(tree):
    result = make_in(tree, "target-skeleton")
    assert (result.returncode, result.stderr) == (0, "")
    return tree / "build/target/skeleton"


def test_a_board_with_a_can_controller_links_only_its_own_and_the_common_folder(built):
    linked = re.findall(r"^LOAD \S*/(hal/\w+)/\w+\.o$", (built / "comanip.map").read_text(), re.MULTILINE)
    assert set(linked) == SHARED | {"hal/skeleton"}


def test_its_stacks_are_bounded_by_the_budget_in_its_folder(built, tree, tmp_path, capsys):
    shared, own = tree / "hal/stack_budget.toml", tree / "hal/skeleton/stack_budget.toml"
    arguments = [str(tmp_path / "stack.json"), f"skeleton={built}"]
    assert stack_report.main([str(shared), str(own), *arguments]) == 0, capsys.readouterr().err
    assert stack_report.main([str(shared), *arguments]) == 1
    assert "add a stack_budget.toml to the port's folder" in capsys.readouterr().err


def test_its_image_runs(built, tree):
    if shutil.which("qemu-system-arm") is None:
        pytest.skip("qemu-system-arm is not installed: make target-deps")
    rows = (line.split("\t") for line in make_in(tree, "images").stdout.splitlines())
    emulator = next(row[5].split() for row in rows if row[0] == "skeleton")
    run = subprocess.run(
        [*emulator, "-icount", "shift=1,sleep=off", "-display", "none", "-kernel", built / "comanip.elf"],
        timeout=PATIENCE_S,
        check=False,
    )
    assert run.returncode == 0


def test_stepping_by_the_simulator_is_refused_without_a_serial_line(tree):
    refused = make_in(tree, "pil", "BOARD=skeleton")
    assert refused.returncode == 2
    assert "BOARD='skeleton': expected an image with a serial line" in refused.stderr
