"""The host side of comanip: the firmware's mathematics for Python (``comanip.core``), and the tools for the bus."""

from comanip import _former_names

_former_names.install()
