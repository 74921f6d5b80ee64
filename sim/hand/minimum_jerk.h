/* How far a hand has come on its way: moves of least jerk (T. Flash, N. Hogan, "The coordination of arm movements",
 * Journal of Neuroscience 5, 1985), and turning a crank, which starts and ends as smoothly. */
#ifndef COMANIP_SIM_MINIMUM_JERK_H
#define COMANIP_SIM_MINIMUM_JERK_H

/* Share of the way after the share x of the time; 0 before and 1 after it. */
double minimum_jerk_share(double x);

/* Turning: the speed rises to a turn per turn_s over half a turn, and falls again over the last half; less than one
 * turn is half rise and half fall. turns is signed. */
double smooth_turn_duration_s(double turns, double turn_s);
double smooth_turn_angle_rad(double turns, double turn_s, double time_s);

#endif
