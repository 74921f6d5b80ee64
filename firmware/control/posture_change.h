/* Out of a dead end: where joints at their ends hold the hand off a target that another posture reaches (the elbow on
 * its other side), the arm goes over to that posture. No gradient leads there, as the way begins away from the target.
 *
 *   watched   the law is in force. When for POSTURE_CHANGE_STILL_S the target stood still, further away than
 * POSTURE_CHANGE_ERROR_M, the hand came no nearer, and a joint was at an end: searched  the arm stands.
 * position_priority() leads one candidate after the other to the target, a step a tick, from postures that have each
 * joint at a quarter or at three quarters of its range. Of those that get there, the one is taken whose joints have the
 *             shortest way to go: the longest of their ways counts;
 *   changing  all joints go there together, none above POSTURE_CHANGE_JOINT_SHARE of its largest speed, the hand not
 * above POSTURE_CHANGE_HAND_MPS, the reduced speed of ISO 10218-1; changed   the arm stands there until the target
 * moves on; left      the law is in force, and nothing is watched.
 *
 * When the target has moved by POSTURE_CHANGE_AWAY_M since the search began, whatever goes on is abandoned, and it is
 * watched again. So there is one search for each place of the target, and the arm comes to rest. */
#ifndef COMANIP_POSTURE_CHANGE_H
#define COMANIP_POSTURE_CHANGE_H

#include "arm_ik.h"
#include "joint_limits.h"

#define POSTURE_CHANGE_ERROR_M 3e-3f
#define POSTURE_CHANGE_STILL_S 0.5f
#define POSTURE_CHANGE_JOINT_SHARE 0.25f
#define POSTURE_CHANGE_HAND_MPS 0.25f
#define POSTURE_CHANGE_AWAY_M 0.02f

typedef enum { POSTURE_WATCHED, POSTURE_SEARCHED, POSTURE_CHANGING, POSTURE_CHANGED, POSTURE_LEFT } posture_phase_t;

typedef struct {
    posture_phase_t phase;
    vector3_t target_m; /* where the target was when it was last watched anew, or when the search began */
    float distance_m;   /* of the hand from it, when it was last watched anew, */
    float still_s;      /* so long ago */
    float candidate_rad[ARM_MAX_JOINTS];
    uint8_t seed, steps;               /* of the candidate */
    float nearest_rad[ARM_MAX_JOINTS]; /* of the candidates that got there */
    float way_rad;                     /* the longest of the joints' ways to it; FLT_MAX: none got there */
} posture_change_t;

/* All members of a request but the target's motion count. */
typedef struct {
    const arm_ik_t *ik;
    const position_priority_config_t *law;
    const joint_limits_config_t *limits;
} posture_change_config_t;

/* Watched anew: at the start, and whenever the cooperation is held or changed. */
void posture_change_init(posture_change_t *self);

/* Before the law: true if it is not to be asked, as feedback_radps, joint_count values, are set, and the target's
 * motion is not to be fed forward. */
bool posture_change_step(posture_change_t *self, const posture_change_config_t *config,
                         const position_priority_request_t *request, float feedback_radps[]);

/* After the law, which found the hand so far from its target. */
void posture_change_watch(posture_change_t *self, const posture_change_config_t *config,
                          const position_priority_request_t *request, float distance_m);

/* Whether the arm moves for it. */
bool posture_change_is_moving(const posture_change_t *self);

#endif
