"""Host side of comanip: the firmware's mathematics from Python (``comanip.core``) and the tools around the bus."""

from comanip import _former_names

_former_names.install()
