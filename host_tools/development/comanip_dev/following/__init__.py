"""How closely the robot's hand follows the person's: recorded motions in a fast loop around the firmware (``make
following``)."""
