"""From the description of an arm to its table and kinematics in C (``make arms``)."""
