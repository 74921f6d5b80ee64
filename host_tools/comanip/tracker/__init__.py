"""Connects a tracker to the bus: parses poses from text, publishes them, and calibrates the tracker's axes."""
