"""Compiles the firmware into the package when the package is installed from a clone of the repository: see
development/comanip_dev/build_core.py.

If the compilation fails, for example because there is no C compiler, the package is installed without the compiled
core. Commands that need the core then report that the core is missing.
"""

import sys
import tempfile
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent
# CORE_CFLAGS of the Makefile, without the warnings.
CORE_FLAGS = ["-std=c11", "-O2", "-ffp-contract=off", "-fno-math-errno"]


class BuildWithCore(build_py):
    def run(self):
        super().run()
        if (HERE.parent / "firmware").is_dir():
            self.build_core(Path(self.build_lib) / "comanip")

    def build_core(self, folder):
        sys.path[:0] = [str(HERE), str(HERE / "development")]
        from comanip_dev import build_core, codegen

        for former in folder.glob("_core*.so"):
            former.unlink()
        with tempfile.TemporaryDirectory() as name:
            generated = Path(name) / "generated"
            codegen.main(generated)
            try:
                build_core.build(generated, Path(name) / "objects", [*CORE_FLAGS, f"-I{generated}"], folder)
            except (OSError, SystemExit) as error:
                print(f"comanip: installed without the compiled core: {error}", file=sys.stderr)


class BinaryDistribution(Distribution):
    def has_ext_modules(self):
        return True


setup(cmdclass={"build_py": BuildWithCore}, distclass=BinaryDistribution)
