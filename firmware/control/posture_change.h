/* Changes the arm's posture when joint limits keep the end effector from a target that another posture reaches, for
 * example with the elbow on the other side. Differential inverse kinematics does not find that posture, because the
 * path to it initially leads away from the target. The phases are:
 *
 *   watched   The initial phase, in which inverse kinematics moves the arm. The search begins once the end effector has
 *             been stuck for POSTURE_CHANGE_STILL_S, that is, the target is at rest and farther away than
 *             POSTURE_CHANGE_ERROR_M, the distance does not change, and a joint is at a limit.
 *   searched  Follows `watched`. The arm is kept at rest, while position_priority() moves candidate postures to the
 *             target, one after the other and one step per tick. Each candidate starts with each joint at one quarter
 *             or three quarters of its range. Among the candidates that reach the target, the one with the smallest
 *             maximum joint displacement is chosen. If none reaches the target, the next phase is `left`.
 *   changing  Follows `searched` if a posture was chosen. All joints move to it together; none exceeds
 *             POSTURE_CHANGE_JOINT_SHARE of its speed limit, and the end effector does not exceed
 *             POSTURE_CHANGE_HAND_MPS, the reduced speed of ISO 10218-1.
 *   changed   Follows `changing` on arrival. The arm holds the posture until the target moves or a joint is pushed
 *             away from the posture.
 *   left      Follows a failed search, or `changed` once the arm no longer holds the posture. Inverse kinematics moves
 *             the arm again, and no further search starts, since it would have the same result.
 *
 * As soon as the target has moved by POSTURE_CHANGE_AWAY_M since the search began, the current phase ends and the
 * target is watched again. There is thus only one search for each position of the target, and the arm comes to rest. */
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
    vector3_t target_m; /* position of the target when the watch was last restarted, or when the search began */
    float distance_m;   /* distance of the end effector from the target when the watch was last restarted */
    float still_s;      /* time since the watch was last restarted */
    float candidate_rad[ARM_MAX_JOINTS];
    uint8_t seed, steps;               /* number of the current candidate, and its steps so far */
    float nearest_rad[ARM_MAX_JOINTS]; /* the nearest of the candidates that reached the target */
    float way_rad;                     /* largest joint displacement to `nearest_rad`; FLT_MAX if there is none */
} posture_change_t;

/* The inverse kinematics and limits in use. The functions below use all members of a position_priority_request_t except
 * `motion`. */
typedef struct {
    const arm_ik_t *ik;
    const position_priority_config_t *law;
    const joint_limits_config_t *limits;
} posture_change_config_t;

/* Starts watching the target afresh. Call at start-up, and whenever the cooperation is interrupted or changed. */
void posture_change_init(posture_change_t *self);

/* Call this before the inverse kinematics. If it returns true, it has set feedback_radps (joint_count values), and
 * neither inverse kinematics nor feedforward may be used in this tick. */
bool posture_change_step(posture_change_t *self, const posture_change_config_t *config,
                         const position_priority_request_t *request, float feedback_radps[]);

/* Call this after the inverse kinematics. distance_m: distance of the end effector from its target. */
void posture_change_watch(posture_change_t *self, const posture_change_config_t *config,
                          const position_priority_request_t *request, float distance_m);

/* Returns true while the arm moves to another posture. */
bool posture_change_is_moving(const posture_change_t *self);

#endif
