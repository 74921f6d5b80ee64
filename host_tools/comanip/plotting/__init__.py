"""Plots of a finished run. run_data and scenes work without matplotlib."""
