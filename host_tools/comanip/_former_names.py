"""Makes modules importable under the names that they had before the package was divided into folders. This module is
to be removed in the next release."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from types import CodeType, ModuleType

NEW_NAMES = {
    "comanip.arm": "comanip.core.arm",
    "comanip.bus_state": "comanip.bus.state",
    "comanip.calibration": "comanip.tracker.calibration",
    "comanip.cooperation": "comanip.core.cooperation",
    "comanip.frame": "comanip.bus.frame",
    "comanip.frame_length": "comanip.bus.frame_length",
    "comanip.logs": "comanip.bus.logs",
    "comanip.mcap_log": "comanip.bus.mcap_log",
    "comanip.operator_client": "comanip.bus.operator_client",
    "comanip.pcap": "comanip.bus.pcap",
    "comanip.plot": "comanip.plotting.__main__",
    "comanip.pose_lines": "comanip.tracker.pose_lines",
    "comanip.tracker_publisher": "comanip.tracker.publisher",
    "comanip.transport": "comanip.bus.transport",
    # Developers' tools, which are available only in a clone of the repository.
    "comanip.arm_codegen": "comanip_dev.arms.codegen",
    "comanip.arm_description": "comanip_dev.arms.description",
    "comanip.bus_doc": "comanip_dev.bus.doc",
    "comanip.bus_report": "comanip_dev.bus.report",
    "comanip.campaign": "comanip_dev.experiments.campaign",
    "comanip.codegen": "comanip_dev.codegen",
    "comanip.experiments": "comanip_dev.experiments",
    "comanip.following": "comanip_dev.following",
    "comanip.gain_search": "comanip_dev.experiments.gain_search",
    "comanip.paper_gains": "comanip_dev.experiments.paper_gains",
    "comanip.pil": "comanip_dev.images.pil",
    "comanip.response_time": "comanip_dev.bus.response_time",
    "comanip.size_report": "comanip_dev.images.size_report",
    "comanip.stack_report": "comanip_dev.images.stack_report",
}


class FormerNames(MetaPathFinder, Loader):
    """Imports the new module and issues a DeprecationWarning when an old name is imported. Python asks this finder
    last, because install() appends it to sys.meta_path."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return spec_from_loader(fullname, self) if fullname in NEW_NAMES else None

    def get_code(self, fullname: str) -> CodeType:
        """Returns code that runs the new module. ``python -m`` calls this method for an old name."""
        new = NEW_NAMES[fullname].removesuffix(".__main__")
        print(f"{fullname} is now {new}; the old name will be removed in the next release", file=sys.stderr)
        return compile(f"import runpy; runpy.run_module('{new}', run_name='__main__', alter_sys=True)", new, "exec")

    def exec_module(self, module: ModuleType) -> None:
        old, new = module.__name__, NEW_NAMES[module.__name__]
        warnings.warn(
            f"{old} is now {new}; the old name will be removed in the next release", DeprecationWarning, stacklevel=2
        )
        try:
            sys.modules[old] = importlib.import_module(new)
        except ModuleNotFoundError as error:
            if error.name != "comanip_dev":
                raise
            raise ModuleNotFoundError(
                f"{old} is now {new}, a developer's tool that is not installed: use it in a clone of the repository, "
                "after `make build`",
                name=old,
            ) from None


def install() -> None:
    sys.meta_path.append(FormerNames())
