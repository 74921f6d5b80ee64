"""The bound reported by `make stack` is correct for constructed call graphs, and covers the stack use of an image in
QEMU."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from comanip_dev.images import stack_report
from comanip_dev.images.stack_report import Graph, UnboundedError
from images import IMAGES, make
from simulation import REPOSITORY
from test_target import TESTED, run

BUDGET = REPOSITORY / "hal" / "stack_budget.toml"
OF_PORTS = sorted((REPOSITORY / "hal").glob("*/stack_budget.toml"))


def graph_of(folder: Path, source: str, indirect: dict[str, list[str]] | None = None) -> Graph:
    (folder / "planted.c").write_text(source)
    subprocess.run(
        ["gcc", "-O1", "-fno-inline", "-fcallgraph-info=su", "-fstack-usage", "-c", "planted.c"], cwd=folder, check=True
    )
    graph = Graph()
    stack_report.read_call_graphs(folder, graph)
    stack_report.resolve(graph, indirect or {})
    return graph


CHAIN = """
    void use(volatile char *p);
    __attribute__((noipa)) static void c(void) { volatile char x[300]; x[0] = 1; }
    __attribute__((noipa)) static void b(void) { volatile char x[50]; x[0] = 1; c(); x[1] = 2; }
    __attribute__((noipa)) static void d(void) { volatile char x[200]; x[0] = 1; }
    void a(void) { volatile char x[10]; x[0] = 1; b(); d(); x[1] = 2; }
"""


def test_the_depth_is_the_sum_along_the_deepest_path(tmp_path):
    graph = graph_of(tmp_path, CHAIN)
    frames = {}
    for line in (tmp_path / "planted.su").read_text().splitlines():
        place, size, _ = line.split("\t")
        frames[place.split(":")[-1]] = int(size)
    depth, way = graph.depth("a")
    assert [stack_report.plain(name) for name in way] == ["a", "b", "c"]
    assert depth == frames["a"] + frames["b"] + frames["c"] > 250


def test_code_without_a_bound_is_refused(tmp_path):
    recursive = (
        "int f(int n); int g(int n) { return n ? f(n - 1) + 1 : 0; } int f(int n) { return n ? g(n - 1) * 2 : 1; }"
    )
    with pytest.raises(UnboundedError, match="recursion: f -> g -> f"):
        graph_of(tmp_path, recursive).depth("f")
    with pytest.raises(UnboundedError, match="no fixed size"):
        graph_of(tmp_path, "int use(char *p); int f(int n) { char x[n]; return use(x); }")
    pointer = "void (*p)(void); void target_one(void) { volatile char x[400]; x[0] = 1; } void f(void) { p(); p(); }"
    with pytest.raises(UnboundedError, match="f calls through a pointer"):
        graph_of(tmp_path, pointer)
    assert graph_of(tmp_path, pointer, {"f": ["target_"]}).depth("f")[0] > 270


@pytest.fixture(scope="module")
def folders() -> dict[str, Path]:
    missing = make("target-check")
    if missing.returncode != 0:
        pytest.skip(missing.stderr.strip())
    built = make("-j2", "target")
    assert built.returncode == 0, built.stderr
    return {image: REPOSITORY / "build" / "target" / image for image in IMAGES}


def report(folders, budget: Path, out: Path) -> int:
    images = (f"{image}={folder}" for image, folder in folders.items())
    return stack_report.main([str(path) for path in (budget, *OF_PORTS, out)] + list(images))


def test_the_committed_budget_holds_and_a_smaller_one_does_not(folders, tmp_path, capsys):
    assert report(folders, BUDGET, tmp_path / "stack.json") == 0, capsys.readouterr().err
    worst = json.loads((tmp_path / "stack.json").read_text())["cortex-m4f"]["thread"]["worst_case_bytes"]
    smaller = tmp_path / "budget.toml"
    smaller.write_text(BUDGET.read_text().replace("budget_bytes = 3072", f"budget_bytes = {worst - 8}", 1))
    assert report(folders, smaller, tmp_path / "stack.json") == 1
    assert f"cortex-m4f: thread: {worst} bytes, budget {worst - 8}: 8 too many" in capsys.readouterr().err


def symbol(image: str, folder: Path, name: str) -> int:
    listing = subprocess.run(
        [IMAGES[image].prefix + "nm", folder / "comanip.elf"], capture_output=True, text=True, check=True
    ).stdout
    return next(int(line.split()[0], 16) for line in listing.splitlines() if line.endswith(f" {name}"))


@pytest.mark.parametrize("image", TESTED)
def test_an_image_uses_no_more_than_the_bound(folders, tmp_path, image):
    """The image uses no more stack than the bound. RAM is zero at the start, so every byte of the stack that is not
    zero at the end was used."""
    if shutil.which(IMAGES[image].emulator[0]) is None:
        pytest.skip(f"{IMAGES[image].emulator[0]} is not installed: make target-deps")
    assert report(folders, BUDGET, tmp_path / "stack.json") == 0
    bounds = json.loads((tmp_path / "stack.json").read_text())[image]
    names = (
        "thread_stack_end",
        "thread_stack_top",
        "exception_stack_top" if IMAGES[image].is_arm else "trap_stack_top",
    )
    bottom, middle, top = (symbol(image, folders[image], f"link_{name}") for name in names)
    assert (middle - bottom, top - middle) == tuple(bound["budget_bytes"] for bound in bounds.values())
    # the stack's address in QEMU's monitor, which on the Cortex-M33 is the non-secure alias
    seen = bottom & 0x0FFFFFFF | 0x20000000 if image == "cortex-m33" else bottom
    _, dump = run(image, folders[image] / "comanip.elf", tmp_path, lambda text: text.count("\rb050") > 200,
                  monitor=f"xp /{(top - bottom) // 4}xw {seen:#x}\n")  # fmt: skip
    words = {}
    for address, values in re.findall(r"^([0-9a-f]+): ((?:0x[0-9a-f]{8} ?)+)", dump, re.MULTILINE):
        for i, value in enumerate(values.split()):
            words[int(address, 16) + 4 * i - seen + bottom] = int(value, 16)
    assert len(words) == (top - bottom) // 4
    for bound, end, begin in zip(bounds.values(), (bottom, middle), (middle, top), strict=True):
        used = begin - min((a for a in range(end, begin, 4) if words[a]), default=begin)
        assert 0 < used <= bound["worst_case_bytes"]
    assert middle - min(a for a in range(bottom, middle, 4) if words[a]) > bounds["thread"]["worst_case_bytes"] / 4


def test_wrong_use(capsys):
    assert stack_report.main([]) == 2
    assert capsys.readouterr().err.startswith("usage:")
