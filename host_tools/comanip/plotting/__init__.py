"""Pictures of a finished run. Only the drawing modules import matplotlib."""
