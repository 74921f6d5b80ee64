#include "minimum_jerk.h"

#include <math.h>

#define PI 3.14159265358979323846

double minimum_jerk_share(double x) {
    if (x <= 0.0 || x >= 1.0) {
        return x <= 0.0 ? 0.0 : 1.0;
    }
    return x * x * x * (10.0 + x * (6.0 * x - 15.0));
}

/* All values are magnitudes; the sign of the turn is applied at the end. */
typedef struct {
    double speed_radps;
    double rise_rad, rise_s; /* angle and duration of the acceleration; the same for the deceleration */
    double cruise_s;
} turn_profile_t;

static turn_profile_t profile_of(double turns, double turn_s) {
    const double whole_rad = 2.0 * PI * fabs(turns);
    turn_profile_t profile = {.speed_radps = 2.0 * PI / turn_s, .rise_rad = fmin(PI, 0.5 * whole_rad)};
    profile.rise_s = 2.0 * profile.rise_rad / profile.speed_radps; /* the mean speed is half the final speed */
    profile.cruise_s = (whole_rad - 2.0 * profile.rise_rad) / profile.speed_radps;
    return profile;
}

/* Returns the angle turned after time_s of the acceleration: the integral of a speed that rises like
 * minimum_jerk_share(). */
static double rise_angle_rad(const turn_profile_t *profile, double time_s) {
    if (profile->rise_s <= 0.0) {
        return 0.0;
    }
    const double x = time_s / profile->rise_s;
    return 2.0 * profile->rise_rad * x * x * x * x * (2.5 + x * (x - 3.0));
}

double smooth_turn_duration_s(double turns, double turn_s) {
    const turn_profile_t profile = profile_of(turns, turn_s);
    return 2.0 * profile.rise_s + profile.cruise_s;
}

double smooth_turn_angle_rad(double turns, double turn_s, double time_s) {
    const turn_profile_t profile = profile_of(turns, turn_s);
    const double left_s = 2.0 * profile.rise_s + profile.cruise_s - time_s;
    double angle_rad;
    if (time_s <= 0.0) {
        angle_rad = 0.0;
    } else if (left_s <= 0.0) {
        angle_rad = 2.0 * PI * fabs(turns);
    } else if (time_s < profile.rise_s) {
        angle_rad = rise_angle_rad(&profile, time_s);
    } else if (left_s < profile.rise_s) {
        angle_rad = 2.0 * PI * fabs(turns) - rise_angle_rad(&profile, left_s);
    } else {
        angle_rad = profile.rise_rad + profile.speed_radps * (time_s - profile.rise_s);
    }
    return copysign(angle_rad, turns);
}
