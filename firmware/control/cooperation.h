/* Algorithm 1: computes the target pose of the end effector from the pose of the person's hand.
 *
 * Names follow the paper: E is the tracker, T the robot's torso, Tv the virtual torso (with the tracker's origin and
 * the torso's axes), H the person's hand, H0 the person's hand at the start, Hv the virtual hand, and R the end
 * effector.
 *
 * The paper's products of dual quaternions are expanded into rotations and translations, without the terms that cancel.
 * In the loop, the constant factors are combined into a 4 x 4 matrix for the hand's rotation and a 3 x 3 matrix for its
 * displacement. */
#ifndef COMANIP_COOPERATION_H
#define COMANIP_COOPERATION_H

#include <stdbool.h>

#include "task.h"

typedef struct {
    quaternion_t tracker_rotation; /* q_Tv^E, unit: the torso's axes in the tracker's frame; q(x, -pi/2) in (9) */
    vector3_t start_offset_m;      /* virtual hand minus end effector at the start, in torso axes; 0 in the paper */
    float motion_scale;            /* factor on the hand's displacement, not on its rotation; 1 in the paper */
} cooperation_config_t;

/* Constants of Algorithm 1's loop, computed in advance. */
typedef struct {
    float turn[4][4];       /* maps the rotation of q_H^E (w x y z) to that of the target */
    float carry[3][3];      /* maps the hand's displacement, in tracker axes, to the virtual hand's, in torso axes */
    float unscale;          /* 1 / motion_scale */
    vector3_t hand_start_m; /* the person's hand at the start, in the tracker frame */
    vector3_t virtual_hand_start_m; /* the virtual hand at the start, in the torso frame */
} cooperation_loop_t;

typedef struct {
    cooperation_config_t config;
    task_t task;
    quaternion_t virtual_hand_start; /* rotation of q_Hv0^H0 */
    task_relation_t relation;        /* the q_task that currently applies */
    task_relation_t blend_from;      /* the q_task from which the blend to the q_task of `task` starts */
    bool latched;
    bool settled; /* the relation is constant, and the loop's constants have been computed from it */
    cooperation_loop_t loop;
    float forward_displacement_m; /* x_H - x_H0 along the torso's x axis, times motion_scale */
    vector3_t relation_m;         /* the relation's translation in torso axes, from the target to the virtual hand */
    pose_t target;                /* the latest target, in the torso frame */
} cooperation_t;

/* Initialises Algorithm 1. hand: q_H^E. robot: q_R^T. cooperation_update() can then blend from the present relation of
 * hand and robot to the relation of the task. */
void cooperation_start(cooperation_t *self, const cooperation_config_t *config, const task_t *task, pose_t hand,
                       pose_t robot);

/* Selects another task, keeps the start poses and releases any latch. The caller must then restart the `blend` of
 * cooperation_update() at 0. */
void cooperation_select(cooperation_t *self, const task_t *task);

/* Makes `hand` and `robot` the new references for displacements (clutch), so that the next target is `robot`. Keeps the
 * present relation: the latched relation or, without a latch, the relation at `blend`. */
void cooperation_clutch(cooperation_t *self, pose_t hand, pose_t robot, float blend);

/* Latches the current q_task (the commanded relation), which then remains constant, as at the grasp in section
 * V-B.3. */
void cooperation_latch(cooperation_t *self);

/* Latches the measured relation conj(q_Rm) q_Hm between the end effector's measured pose q_Rm and the virtual hand's
 * pose q_Hm. robot: q_Rm, which becomes the target. */
void cooperation_latch_measured(cooperation_t *self, pose_t robot);

/* Runs one pass of Algorithm 1's loop, which computes self->target, q_R^Tv = q_Hv^Tv conj(q_task), in the torso frame.
 * blend: interpolates q_task from `blend_from` (0) to the q_task of the task (1); always 1 in the paper. */
void cooperation_update(cooperation_t *self, const pose_t *hand, float blend);

/* Returns the twist of the target of the last cooperation_update(), given the hand's twist in the tracker frame.
 * Excludes the motion due to a blend. */
twist_t cooperation_target_motion(const cooperation_t *self, const twist_t *hand);

#endif
