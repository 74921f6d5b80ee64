"""``make bitexact``: for the same input, controller_step() must produce the same bytes with every compiler and
processor.

``bitexact.py BUILD [--smoke]``. Runs the host builds directly and the images in QEMU. The first host build is the
reference, with which every other build is compared tick by tick. Prints a table and writes BUILD/reports/bitexact.json.
The exit status is 1 if any build differs. QEMU executes instructions as specified; nothing was run on silicon.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import c_library  # noqa: E402
from images import EMULATED, IMAGES, REPOSITORY, make  # noqa: E402

SIMULATOR = REPOSITORY / "build" / "host" / "comanip-sim"
RUNNER = REPOSITORY / "tests" / "bitexact" / "runner.c"
SCENARIOS = ("pour", "teleop", "mirror", "handover", "crank")
EVENTS = ["--gap", "4:0.2", "--dropout", "0.02", "--tracker-clock", "4294000000"]
VECTOR_TICKS, SMOKE_VECTOR_TICKS = 20_000, 4_000
CORE_FLAGS = ["-std=c11", "-ffp-contract=off", "-fno-math-errno", f"-I{REPOSITORY / 'build' / 'generated'}"]
HOSTS = [(compiler, level) for compiler in ("gcc", "clang") for level in ("-O0", "-O2", "-O3")]
SEMIHOSTING = [
    "-display",
    "none",
    "-monitor",
    "none",
    "-serial",
    "null",
    "-semihosting-config",
    "enable=on,target=native",
]
HASH_BYTES = 4
TIMEOUT_S = 1800  # needed because an image that panics halts, and its emulator never ends


@dataclass(frozen=True)
class Result:
    """The result of one build. `differs_at_tick` counts from 0, and is None if all ticks are equal."""

    build: str
    ticks: int
    differs_at_tick: int | None
    skipped: str = ""


def make_input(folder: Path, smoke: bool) -> None:
    runs = (
        [("teleop", "fd", ["--duration", "3"])] if smoke else [(s, p, []) for p in ("fd", "classic") for s in SCENARIOS]
    )
    runs += [] if smoke else [("teleop", "fd", EVENTS), ("pour", "classic", EVENTS)]
    paths = []
    for number, (scenario, profile, options) in enumerate(runs):
        out = folder / "runs" / str(number)
        command = [SIMULATOR, "--scenario", scenario, "--profile", profile, "--quiet", "--out", out, *options]
        (out / "bus.log").unlink(missing_ok=True)  # so that no old log is used if the run fails
        subprocess.run([str(part) for part in command], check=False, stderr=subprocess.DEVNULL)
        paths.append(out / "bus.log")
    ticks = SMOKE_VECTOR_TICKS if smoke else VECTOR_TICKS
    subprocess.run(
        [sys.executable, RUNNER.with_name("write_input.py"), folder / "input.bin", str(ticks), *paths], check=True
    )


def run_in(folder: Path, name: str, command: list[str]) -> bytes:
    place = folder / name
    place.mkdir(parents=True, exist_ok=True)
    (place / "input.bin").unlink(missing_ok=True)
    (place / "input.bin").symlink_to(folder / "input.bin")
    subprocess.run(command, cwd=place, check=True, stdin=subprocess.DEVNULL, timeout=TIMEOUT_S)
    return (place / "output.bin").read_bytes()


def compile_host(program: Path, compiler: str, *flags: str) -> None:
    command = [compiler, *CORE_FLAGS, *flags]
    parts = [str(target) for target, _ in c_library.objects([*c_library.CORE, RUNNER], command)]
    subprocess.run([*command, *parts, "-lm", "-o", str(program)], check=True)


def host_output(folder: Path, compiler: str, level: str) -> bytes:
    name = f"{compiler}{level}"
    (folder / name).mkdir(parents=True, exist_ok=True)
    compile_host(folder / name / "runner", compiler, level)
    return run_in(folder, name, [str(folder / name / "runner")])


def image_output(folder: Path, image: str) -> bytes:
    build = folder / "target"
    elf = build / image / "comanip.elf"
    built = make(str(elf), f"TARGET_MAIN={RUNNER.relative_to(REPOSITORY)}", f"TARGET_BUILD={build}", "PROFILE=both")
    if built.returncode != 0:
        raise SystemExit(f"make bitexact: {image}: {built.stderr}")
    return run_in(folder, image, [*IMAGES[image].emulator, *SEMIHOSTING, "-kernel", str(elf)])


def compared(build: str, output: bytes, reference: bytes) -> Result:
    ticks = len(output) // HASH_BYTES
    if output == reference:
        return Result(build, ticks, None)
    pairs = zip(range(0, len(reference), HASH_BYTES), range(0, len(output), HASH_BYTES))
    unequal = (i for i, j in pairs if reference[i : i + HASH_BYTES] != output[j : j + HASH_BYTES])
    return Result(build, ticks, next(unequal, min(len(reference), len(output))) // HASH_BYTES)


def missing(build: str, program: str, package: str) -> Result | None:
    return None if shutil.which(program) else Result(build, 0, None, f"{program} is missing: {package}")


def run(folder: Path, smoke: bool) -> list[Result]:
    folder.mkdir(parents=True, exist_ok=True)
    make_input(folder, smoke)
    jobs = []
    for compiler, level in HOSTS:
        jobs.append(
            (
                f"x86-64 {compiler} {level}",
                missing("", compiler, f"apt-get install {compiler}"),
                host_output,
                (compiler, level),
            )
        )
    for image in map(IMAGES.__getitem__, EMULATED):
        jobs.append(
            (
                f"{image.name} gcc -O2, QEMU",
                missing("", image.emulator[0], "make target-deps"),
                image_output,
                (image.name,),
            )
        )
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        outputs = [
            None if absent else pool.submit(function, folder, *arguments) for _, absent, function, arguments in jobs
        ]
        outputs = [output.result() if output else None for output in outputs]
    reference = next(output for output in outputs if output)
    return [
        Result(name, 0, None, absent.skipped) if absent else compared(name, output, reference)
        for (name, absent, _, _), output in zip(jobs, outputs)
    ]


def show(results: list[Result]) -> None:
    table = Table(title="controller_step(): the bytes sent for the same input", title_justify="left")
    for header in ("build", "ticks", "compared with the first"):
        table.add_column(header, justify="right" if header == "ticks" else "left")
    for result in results:
        verdict = "equal" if result.differs_at_tick is None else f"[red]differs at tick {result.differs_at_tick}[/]"
        table.add_row(result.build, str(result.ticks), result.skipped or verdict)
    Console().print(table)


def main(argv: list[str]) -> int:
    build, smoke = Path(argv[0]).resolve(), "--smoke" in argv
    results = run(build / ("bitexact-smoke" if smoke else "bitexact"), smoke)
    report = build / "reports" / "bitexact.json"
    report.parent.mkdir(parents=True, exist_ok=True)
    report.write_text(json.dumps({"smoke": smoke, "builds": [asdict(result) for result in results]}, indent=1) + "\n")
    show(results)
    differs = any(result.differs_at_tick is not None for result in results)
    print("make bitexact: builds differ, see the table" if differs else "make bitexact: all builds that ran are equal")
    return differs


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
