"""Documentation, load and response times of the bus, computed from the DBC."""
