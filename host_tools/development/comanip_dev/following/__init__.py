"""Measures how closely the end effector follows the person's hand, with recorded motions and the firmware in a fast
closed loop without physics (``make following``)."""
