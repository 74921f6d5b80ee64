#include "measure.h"

const char *measure_unit(measure_t measure) {
    switch (measure) {
    case MEASURE_SETTLED_POSITION:
    case MEASURE_FOLLOWING_RMS:
    case MEASURE_RELATION_RMS:
    case MEASURE_DISPLACEMENT:
    case MEASURE_WAY_X:
    case MEASURE_WAY_Y:
    case MEASURE_WAY_Z:
    case MEASURE_CLEARANCE:
    case MEASURE_SELF_CLEARANCE:
    case MEASURE_AIM: return "mm";
    case MEASURE_TILT:
    case MEASURE_CUP_TILT_PEAK:
    case MEASURE_TURN: return "deg";
    case MEASURE_WATER_POURED:
    case MEASURE_WATER_CAUGHT: return "%";
    case MEASURE_FORCE_RMS:
    case MEASURE_FORCE_PEAK: return "N";
    case MEASURE_CARRIED_FOR: return "s";
    case MEASURE_TURNS: return "turn";
    case MEASURE_FLOW_WHILE_MOVING:
    case MEASURE_DROPS:
    case MEASURE_HELD: return "";
    }
    return "";
}

bool measure_needs_target(measure_t measure) {
    return measure == MEASURE_SETTLED_POSITION || measure == MEASURE_FOLLOWING_RMS;
}

static bool is_displacement_along_axis(measure_t measure) {
    return measure == MEASURE_WAY_X || measure == MEASURE_WAY_Y || measure == MEASURE_WAY_Z;
}

bool measure_compares_with_begin(measure_t measure) {
    return measure == MEASURE_RELATION_RMS || measure == MEASURE_DISPLACEMENT || measure == MEASURE_TURN ||
           is_displacement_along_axis(measure);
}

bool measure_is_of_built_in_motion(measure_t measure) {
    return measure_compares_with_begin(measure) || measure == MEASURE_SETTLED_POSITION || measure == MEASURE_TILT;
}

bool measure_is_of_whole_run(measure_t measure) {
    switch (measure) {
    case MEASURE_WATER_POURED:
    case MEASURE_WATER_CAUGHT:
    case MEASURE_FLOW_WHILE_MOVING:
    case MEASURE_DROPS:
    case MEASURE_HELD:
    case MEASURE_TURNS:
    case MEASURE_CARRIED_FOR: return true;
    default: return false;
    }
}
