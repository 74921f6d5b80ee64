"""Plots of a finished run. Only the modules that draw import matplotlib."""
