"""The bus as the DBC describes it: its documentation, its load and its response times."""
