/* Algorithm 1: computes the target pose of the end effector from the pose of the person's hand.
 *
 * Names follow the paper: E is the tracker, T the robot's torso, Tv the virtual torso (tracker's origin, torso's axes),
 * H0 the person's hand at the start, Hv the virtual hand, R the end effector.
 *
 * The paper's products of dual quaternions are written as rotations and translations, without terms that cancel. In the
 * loop the constant factors are combined into a 4 x 4 matrix for the hand's rotation and a 3 x 3 matrix for its
 * displacement. */
#ifndef COMANIP_COOPERATION_H
#define COMANIP_COOPERATION_H

#include <stdbool.h>

#include "task.h"

typedef struct {
    quaternion_t tracker_rotation; /* q_Tv^E, unit: the torso's axes in the tracker's frame; q(x, -pi/2) in (9) */
    vector3_t start_offset_m;      /* person's hand at the start minus end effector, in torso axes; 0 in the paper */
    float motion_scale;            /* factor on the hand's displacement, not on its rotation; 1 in the paper */
} cooperation_config_t;

/* The loop's constants. */
typedef struct {
    float turn[4][4];       /* maps the rotation of q_H^E (w x y z) to that of the target */
    float carry[3][3];      /* maps the hand's displacement in tracker axes to the virtual hand, in torso axes */
    float unscale;          /* 1 / motion_scale */
    vector3_t hand_start_m; /* in the tracker frame */
    vector3_t virtual_hand_start_m; /* in the torso frame */
} cooperation_loop_t;

typedef struct {
    cooperation_config_t config;
    task_t task;
    quaternion_t virtual_hand_start; /* rotation of q_Hv0^H0 */
    task_relation_t relation;        /* the q_task in force */
    task_relation_t blend_from;      /* the q_task that the present one is blended from */
    bool latched;
    bool settled; /* the relation in force is constant, and the loop's constants are computed from it */
    cooperation_loop_t loop;
    float forward_displacement_m; /* x_H - x_H0 in torso axes, scaled */
    vector3_t relation_m;         /* the relation's translation in torso axes: from the target to the virtual hand */
    pose_t target;                /* latest target, in the torso frame */
} cooperation_t;

/* Initialises Algorithm 1. hand: q_H^E. robot: q_R^T. A blend to the task starts from the present relation of both. */
void cooperation_start(cooperation_t *self, const cooperation_config_t *config, const task_t *task, pose_t hand,
                       pose_t robot);

/* Selects another task and keeps the start poses. The caller then restarts `blend` of cooperation_update() at 0.
 * Releases a latch. */
void cooperation_select(cooperation_t *self, const task_t *task);

/* Takes a new reference (clutch): displacements are relative to `hand` and `robot` from now on. The task continues with
 * the relation in force (at `blend`, or latched), so that the next target is `robot`. */
void cooperation_clutch(cooperation_t *self, pose_t hand, pose_t robot, float blend);

/* Section V-B.3, at grasp: latches the q_task in force, which then stays constant (the commanded relation). */
void cooperation_latch(cooperation_t *self);

/* Latches the measured relation conj(q_Rm) q_Hm. robot: q_Rm, which becomes the target. */
void cooperation_latch_measured(cooperation_t *self, pose_t robot);

/* Computes one pass of Algorithm 1's loop up to self->target, q_R^Tv = q_Hv^Tv conj(q_task), in the torso frame.
 * blend: 0..1, interpolates q_task from `blend_from` to that of the task; 1 in the paper. */
void cooperation_update(cooperation_t *self, const pose_t *hand, float blend);

/* The twist of the target of the last cooperation_update() for a twist of the hand in the tracker frame. It does not
 * include the motion due to a blend. */
twist_t cooperation_target_motion(const cooperation_t *self, const twist_t *hand);

#endif
