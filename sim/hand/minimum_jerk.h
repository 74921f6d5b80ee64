/* Motion profiles of the hand: for minimum-jerk moves (T. Flash, N. Hogan, "The coordination of arm movements", Journal
 * of Neuroscience 5, 1985), and for turns of a crank, whose speed rises and falls with the same smooth profile. */
#ifndef COMANIP_SIM_MINIMUM_JERK_H
#define COMANIP_SIM_MINIMUM_JERK_H

/* Returns the fraction of the path covered once the fraction x of the duration has passed: 0 before the move and 1
 * after it. */
double minimum_jerk_share(double x);

/* These functions return the duration of a crank turn and the angle turned by a given time. The speed rises to one turn
 * per turn_s over the first half turn and falls over the last half turn. A motion of less than one turn accelerates
 * over its first half and decelerates over its second. `turns` is signed. */
double smooth_turn_duration_s(double turns, double turn_s);
double smooth_turn_angle_rad(double turns, double turn_s, double time_s);

#endif
