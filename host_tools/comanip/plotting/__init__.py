"""Plots a finished run. The modules run_data and scenes work without matplotlib."""
