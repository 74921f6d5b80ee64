"""``make pil-matrix``: runs whole scenarios with each target image in the loop, in QEMU, and compares their logs with
runs of the firmware on the host.

Usage: ``pil_matrix.py BUILD``. The bus logs, including the joint commands, must be equal byte for byte. Prints a line
for each finished run and writes BUILD/reports/pil.json. The exit status is 1 if any log differs. Takes about an hour
on two cores.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from images import IMAGES, REPOSITORY, SERIAL, make

SCENARIOS = ("teleop", "pour", "mirror")
SIMULATOR, PROGRAM = (REPOSITORY / "build" / "host" / f"comanip-{name}" for name in ("sim", "pil"))


def joint_commands(log: bytes) -> int:
    return log.count(b" 050##")


def elf_of(image: str) -> Path:
    return REPOSITORY / "build" / "target" / f"{image}-pil" / "comanip.elf"


def run(folder: Path, scenario: str, image: str | None) -> bytes:
    """Returns the bus log of a run with the image, or with the firmware on the host if `image` is None. Returns an
    empty log if the run failed."""
    out = folder / scenario / (image or "host")
    options = ["--scenario", scenario, "--quiet", "--out", str(out)]
    command = (
        [str(SIMULATOR)]
        if image is None
        else [
            sys.executable,
            "-m",
            "comanip_dev.images.pil",
            " ".join(IMAGES[image].emulator),
            str(elf_of(image)),
            str(PROGRAM),
        ]
    )
    done = subprocess.run([*command, *options], check=False, cwd=REPOSITORY)
    return (out / "bus.log").read_bytes() if done.returncode == 0 else b""


def main(argv: list[str]) -> int:
    build = Path(argv[0]).resolve()
    built = make(
        "PROFILE=fd",
        *(str(elf_of(image).relative_to(REPOSITORY)) for image in SERIAL),
        str(PROGRAM.relative_to(REPOSITORY)),
    )
    if built.returncode != 0:
        raise SystemExit(f"make pil-matrix: {built.stderr}")
    results = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        hosts = dict(
            zip(SCENARIOS, pool.map(lambda scenario: run(build / "pil-matrix", scenario, None), SCENARIOS), strict=True)
        )
        jobs = [(scenario, image) for scenario in SCENARIOS for image in SERIAL]
        logs = pool.map(lambda job: run(build / "pil-matrix", *job), jobs)
        for (scenario, image), log in zip(jobs, logs, strict=True):
            commands, equal = joint_commands(log), log != b"" and log == hosts[scenario]
            results.append({"scenario": scenario, "image": image, "joint_commands": commands, "equal": equal})
            print(
                f"{scenario:8} {image:14} {commands:6} joint commands, bus log {'equal' if equal else 'DIFFERS'}",
                flush=True,
            )
    report = build / "reports" / "pil.json"
    report.parent.mkdir(parents=True, exist_ok=True)
    report.write_text(json.dumps(results, indent=1) + "\n")
    return not all(result["equal"] for result in results)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
