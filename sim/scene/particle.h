/* A particle of the water: a frictionless sphere, whose rotation therefore need not be simulated. */
#ifndef COMANIP_SIM_PARTICLE_H
#define COMANIP_SIM_PARTICLE_H

#include <stdbool.h>

#define NO_CUP (-1)

typedef struct {
    double position_m[3];
    double velocity_mps[3];
    double radius_m;
    double inverse_mass_pkg; /* 1/kg; 0 for a wall */
    int cup;                 /* index of the cup that contains the particle, or NO_CUP */
    bool is_spilt;           /* lies on the ground and no longer has contacts */
} particle_t;

#endif
