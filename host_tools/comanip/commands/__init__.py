"""One module per command of ``comanip``."""
