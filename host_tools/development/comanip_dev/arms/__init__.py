"""Generates an arm's table and kinematics in C from its description (``make arms``)."""
