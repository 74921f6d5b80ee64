"""Makes ``comanip._core`` the sanitised module, in this process and in every Python process that it starts. Python runs
this file when it starts, because run.py adds this folder to PYTHONPATH.

AddressSanitizer must be loaded before anything else, so Python restarts itself with LD_PRELOAD. Other programs, such as
QEMU, do not inherit LD_PRELOAD.
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
    """An import finder that returns the sanitised core. It precedes all other finders, so that the plain core is never
    found."""

    @staticmethod
    def find_spec(fullname, path=None, target=None):
        return importlib.util.spec_from_file_location(fullname, CORE) if fullname == "comanip._core" else None


class SanitisedPopen(subprocess.Popen):
    """Adds the variables of the sanitised run to an environment that a test passes explicitly. Without them the child
    process would use the plain core."""

    def __init__(self, *arguments, env=None, **options):
        super().__init__(*arguments, env=None if env is None else {**SETTINGS, **env}, **options)


load_runtime()
sys.meta_path.insert(0, SanitisedCore)
subprocess.Popen = SanitisedPopen
