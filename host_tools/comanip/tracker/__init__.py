"""A tracker as a node on the bus: poses from text, their publication, and the calibration of its axes."""
