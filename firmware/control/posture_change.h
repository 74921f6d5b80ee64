/* Changes the arm's posture when joint limits keep the end effector from a target that another posture reaches, for
 * example with the elbow on its other side. Differential inverse kinematics does not find that posture, because the
 * path to it leads away from the target at first. The phases are:
 *
 *   watched   Inverse kinematics is in force. The search begins when, for POSTURE_CHANGE_STILL_S, the target was at
 *             rest and farther away than POSTURE_CHANGE_ERROR_M, the end effector came no nearer, and a joint was at a
 *             limit.
 *   searched  The arm is at rest. position_priority() moves candidates to the target one after the other, one step per
 *             tick. They start from postures with each joint at one or three quarters of its range. Of the candidates
 *             that reach the target, the one with the shortest path is chosen, by the largest of its joint
 *             displacements.
 *   changing  All joints move to the chosen posture together, none above POSTURE_CHANGE_JOINT_SHARE of its speed limit,
 *             the end effector not above POSTURE_CHANGE_HAND_MPS, the reduced speed of ISO 10218-1.
 *   changed   The arm holds that posture until the target moves.
 *   left      Inverse kinematics is in force, and the target is not watched.
 *
 * When the target has moved by POSTURE_CHANGE_AWAY_M since the search began, the present phase ends, and the target is
 * watched again. So there is one search for each position of the target, and the arm comes to rest. */
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
    vector3_t target_m; /* target when the watch was last restarted, or when the search began */
    float distance_m;   /* distance of the end effector from it when the watch was last restarted */
    float still_s;      /* time since then */
    float candidate_rad[ARM_MAX_JOINTS];
    uint8_t seed, steps;               /* number of the candidate, and its steps so far */
    float nearest_rad[ARM_MAX_JOINTS]; /* nearest of the candidates that reached the target */
    float way_rad;                     /* largest joint displacement to it; FLT_MAX: no candidate reached the target */
} posture_change_t;

/* The inverse kinematics and limits in use. The functions below use all members of a request but the target's motion.
 * */
typedef struct {
    const arm_ik_t *ik;
    const position_priority_config_t *law;
    const joint_limits_config_t *limits;
} posture_change_config_t;

/* Restarts the watch. Call it at the start, and whenever the cooperation is held or changed. */
void posture_change_init(posture_change_t *self);

/* To be called before the inverse kinematics. True if it has set feedback_radps (joint_count values): inverse
 * kinematics and feedforward are then not used in this tick. */
bool posture_change_step(posture_change_t *self, const posture_change_config_t *config,
                         const position_priority_request_t *request, float feedback_radps[]);

/* To be called after the inverse kinematics. distance_m: distance of the end effector from its target. */
void posture_change_watch(posture_change_t *self, const posture_change_config_t *config,
                          const position_priority_request_t *request, float distance_m);

/* True while the arm moves to another posture. */
bool posture_change_is_moving(const posture_change_t *self);

#endif
