/* Compares what the drives report with what they are commanded, and so detects faults of encoders and drives.
 *
 * Let F be the motion of a drive that follows its commands without lag, and S that of a drive with the first-order lag
 * drive_lag_max_s of the arm's description: S is F - drive_lag_max_s u, where u is the commanded velocity behind that
 * lag. A healthy drive reports a position within the band between S and F. A report is sampled when the last command
 * arrives or later, so the band extends to the position that F has reached since then. The checks of each joint, in
 * their order of precedence:
 *
 *   silence    the last report is not older than the timeout of JointState.
 *   error      the drive reports no error.
 *   range      the position is within the arm's range, to JOINT_WATCH_DEVIATION_RAD.
 *   step       from one report to the next, the position changes at most as within the band, to
 *              JOINT_WATCH_DEVIATION_RAD.
 *   deviation  the position is within the band, to JOINT_WATCH_DEVIATION_RAD. A band that does not include the position
 *              is shifted towards it by 0.5 mrad/s, which allows for small errors of a drive's speed.
 *   mode       the reported mode differs from the commanded one for at most JOINT_WATCH_MODE_MS.
 *
 * The last four are checked while the drives are powered. All computations are in integers: positions in steps of the
 * bus's resolution (1 urad), velocities in steps of the bus's resolution (1 mrad/s), times in ms. In each ms, a
 * velocity of one step moves a joint by one step. A tick that comes late counts as the number of ticks that have
 * passed. */
#ifndef COMANIP_JOINT_WATCH_H
#define COMANIP_JOINT_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "../arms/arm.h"
#include "../protocol/can_protocol.h"

#define JOINT_WATCH_DEVIATION_RAD 10e-3f
#define JOINT_WATCH_MODE_MS 20
/* A joint is at rest if its reports have stayed within this distance for this time. */
#define JOINT_WATCH_REST_RAD 1e-3f
#define JOINT_WATCH_REST_MS 50

typedef enum {
    JOINT_WATCH_OK,
    JOINT_WATCH_SILENT,
    JOINT_WATCH_ERROR,
    JOINT_WATCH_OUT_OF_RANGE,
    JOINT_WATCH_DEVIATES, /* step or deviation */
    JOINT_WATCH_WRONG_MODE,
} joint_watch_finding_t;

typedef struct {
    joint_watch_finding_t finding; /* of all joints, the one with the highest precedence */
    bool in_range;                 /* all joints are within the arm's range, to JOINT_WATCH_DEVIATION_RAD */
    bool at_rest;                  /* all joints are at rest, by their reports */
} joint_watch_result_t;

typedef struct {
    int32_t min_urad, max_urad; /* the arm's range, widened by JOINT_WATCH_DEVIATION_RAD */
    /* the last report */
    int32_t position_urad;
    uint32_t received_us;
    drive_error_t error;
    drive_mode_t mode;
    bool is_reported; /* within the timeout */
    bool is_new;      /* since the last check */
    /* the last command */
    int32_t velocity_mradps;
    drive_mode_t commanded_mode;
    int32_t lagging; /* u, in steps of 1/64 mrad/s */
    /* the comparison */
    int32_t ahead_urad;   /* F less the position */
    int32_t checked_urad; /* the position at the last check of a new report */
    int32_t fast_urad;    /* motion of F since then */
    int32_t was_lagging;  /* u at that time */
    int32_t wrong_mode_ms;
    int32_t rest_urad; /* the joint has been near this position for rest_ms */
    int32_t rest_ms;   /* at most JOINT_WATCH_REST_MS */
} joint_watch_joint_t;

typedef struct {
    int32_t joint_count, tick_ms, lag_ms;
    uint32_t timeout_us;
    uint32_t counted_us; /* the time up to which ticks are counted */
    int32_t elapsed_ms;  /* whole ticks from the last check to this one, at most 100 */
    bool is_running;     /* checked at least once */
    bool is_powered;
    bool shifts; /* in this tick; every other one */
    joint_watch_joint_t joint[ARM_MAX_JOINTS];
} joint_watch_t;

/* tick_ms: 1 to 10. timeout_us: timeout of JointState on this bus. */
void joint_watch_init(joint_watch_t *self, const arm_t *arm, uint32_t tick_ms, uint32_t timeout_us);

/* Takes a drive's report. joint: 0..ARM_MAX_JOINTS - 1. received_us: must not be after the time of the next check. */
void joint_watch_report(joint_watch_t *self, int joint, const joint_state_t *state, uint32_t received_us);

/* Checks all joints. Call it once per tick, after the reports and before the command. It discards a report that has
 * timed out, which would otherwise look fresh again when the clock wraps after 71 minutes. */
joint_watch_result_t joint_watch_check(joint_watch_t *self, uint32_t now_us);

/* Takes the command that is sent in this tick, whose values are finite, and whether the drives are powered in it. Call
 * it once per tick, unless no command is sent. */
void joint_watch_command(joint_watch_t *self, const joint_cmd_t *command, bool is_powered);

#endif
