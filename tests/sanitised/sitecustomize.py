"""Python runs this at its start, since run.py puts this folder in PYTHONPATH: ``comanip._core`` is then the sanitised
module, in this process and in every Python that it starts.

AddressSanitizer has to be loaded before anything else. So Python starts itself anew with it. Other programs, such as
QEMU, do not inherit it.
"""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

CORE = Path(os.environ["COMANIP_SANITISED"]) / "_core.abi3.so"
RUNTIME = os.environ["COMANIP_SANITISER_RUNTIME"]
SETTINGS = {
    name: os.environ[name]
    for name in (
        "COMANIP_SANITISED", "COMANIP_SANITISER_RUNTIME", "PYTHONPATH", "PYTHONMALLOC", "ASAN_OPTIONS", "UBSAN_OPTIONS",
    )
}  # fmt: skip


def load_runtime() -> None:
    first, _, others = os.environ.get("LD_PRELOAD", "").partition(":")
    if first != RUNTIME:
        os.environ["LD_PRELOAD"] = ":".join(filter(None, (RUNTIME, first, others)))
        os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])
    if others:
        os.environ["LD_PRELOAD"] = others
    else:
        del os.environ["LD_PRELOAD"]


class SanitisedCore:
    """Asked before all others, so that the plain core is never found."""

    @staticmethod
    def find_spec(fullname, path=None, target=None):
        return importlib.util.spec_from_file_location(fullname, CORE) if fullname == "comanip._core" else None


class SanitisedPopen(subprocess.Popen):
    """A child whose environment a test has chosen needs these variables as well, or it would use the plain core."""

    def __init__(self, *arguments, env=None, **options):
        super().__init__(*arguments, env=None if env is None else {**SETTINGS, **env}, **options)


load_runtime()
sys.meta_path.insert(0, SanitisedCore)
subprocess.Popen = SanitisedPopen
