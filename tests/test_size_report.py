"""`make size`: its figures agree with the toolchain's, and exceeding a budget is reported."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
from comanip_dev.images import size_report
from images import IMAGES, make
from simulation import REPOSITORY

BUDGET = REPOSITORY / "hal" / "size_budget.toml"


@pytest.fixture(scope="module")
def maps() -> dict[str, Path]:
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    built = make("-j2", "target")
    assert built.returncode == 0, built.stderr
    return {image: REPOSITORY / "build" / "target" / image / "comanip.map" for image in IMAGES}


def report(maps, budget: Path, out: Path, *options: str) -> int:
    return size_report.main([str(budget), str(out), *options, *(f"{image}={path}" for image, path in maps.items())])


def test_totals_match_the_toolchains_size(maps):
    for image, path in maps.items():
        output = subprocess.run(
            [IMAGES[image].prefix + "size", path.with_suffix(".elf")], capture_output=True, text=True, check=True
        )
        text, data, bss = map(int, output.stdout.splitlines()[1].split()[:3])
        found = size_report.read_map(path)
        assert (found.total.text, found.total.data, found.total.bss) == (text, data, bss), image
        for kind, total in zip(size_report.KINDS, (text, data, bss), strict=True):
            assert sum(getattr(size, kind) for size in found.modules.values()) == total


def test_functions_are_counted_in_their_module(maps):
    """The sizes that nm lists for the symbols of a module are included in the module's figure."""
    listing = subprocess.run(
        [IMAGES["cortex-m4f"].prefix + "nm", "-S", maps["cortex-m4f"].with_suffix(".elf")],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    sizes = {line.split()[3]: int(line.split()[1], 16) for line in listing.splitlines() if len(line.split()) == 4}
    modules = size_report.read_map(maps["cortex-m4f"]).modules
    assert modules["firmware/controller"].text >= sizes["controller_step"]
    assert modules["hal/slcan/slcan_hal"].bss == sizes["slcan_hal_link"]
    assert modules["stack"].bss == 3072 + 256


def test_the_image_fits_a_small_cortex_m4f(maps):
    """The image fits into 64 KiB of flash and 16 KiB of RAM, including both stacks."""
    total = size_report.read_map(maps["cortex-m4f"]).total
    assert total.text + total.data <= 64 * 1024
    assert total.data + total.bss <= 16 * 1024


def test_the_committed_budget_holds(maps, tmp_path, capsys):
    assert report(maps, BUDGET, tmp_path / "size.json") == 0, capsys.readouterr().err
    written = json.loads((tmp_path / "size.json").read_text())
    assert written["cortex-m4f"]["modules_bytes"]["firmware/protocol/e2e"]["text"] > 0
    assert written["cortex-m4f"]["total_bytes"]["text"] > 10_000


def test_an_exceeded_budget_is_reported_with_the_difference(maps, tmp_path, capsys):
    lower = tmp_path / "budget.toml"
    found = size_report.read_map(maps["cortex-m4f"]).modules["firmware/protocol/e2e"].text
    before, image, after = BUDGET.read_text().partition("[cortex-m4f]")
    after = after.replace(f'"firmware/protocol/e2e" = [{found}, ', f'"firmware/protocol/e2e" = [{found - 7}, ', 1)
    lower.write_text(before + image + after.replace('"firmware/control/task" = ', '"firmware/another" = ', 1))
    assert report(maps, lower, tmp_path / "size.json") == 1
    output = capsys.readouterr().err
    assert f"cortex-m4f: firmware/protocol/e2e: text {found} bytes, budget {found - 7}: 7 too many" in output
    assert re.search(r"cortex-m4f: firmware/control/task: no budget", output)


def test_a_new_budget_is_the_current_size(maps, tmp_path):
    fresh = tmp_path / "budget.toml"
    assert report(maps, fresh, tmp_path / "size.json", "--update") == 0
    assert report(maps, fresh, tmp_path / "size.json") == 0


def test_wrong_use(capsys):
    assert size_report.main([]) == 2
    assert capsys.readouterr().err.startswith("usage:")
