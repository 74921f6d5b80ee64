/* Algorithm 1: from the pose of the human's hand to the pose the robot's hand shall take.
 *
 * Names follow the paper: E is the tracker, T the robot's torso, Tv the virtual torso (tracker's origin, torso's axes),
 * H0 the human's hand at the start, Hv the virtual hand.
 *
 * The paper's products of dual quaternions, written as rotation and translation, without what cancels. In the loop the
 * constant factors are folded into one 4 x 4 matrix for the hand's rotation and one 3 x 3 for its displacement. */
#ifndef COMANIP_COOPERATION_H
#define COMANIP_COOPERATION_H

#include <stdbool.h>

#include "task.h"

typedef struct {
    quaternion_t
        tracker_rotation;     /* q_Tv^E, unit: the torso's axes seen from the tracker; the paper's (9) is q(x, -pi/2) */
    vector3_t start_offset_m; /* in torso axes: where the person's hand is at the start, less where the robot's hand
                                 is; 0 is the paper */
    float motion_scale;       /* multiplies the hand's displacement, never its rotation; 1 is the paper */
} cooperation_config_t;

/* The loop's constants. */
typedef struct {
    float turn[4][4];               /* q_H^E's rotation (w x y z) to the target's */
    float carry[3][3];              /* the hand's displacement in tracker axes to the virtual hand's in torso axes */
    float unscale;                  /* 1 / motion_scale */
    vector3_t hand_start_m;         /* in the tracker frame */
    vector3_t virtual_hand_start_m; /* in the torso frame */
} cooperation_loop_t;

typedef struct {
    cooperation_config_t config;
    task_t task;
    quaternion_t virtual_hand_start; /* rotation of q_Hv0^H0 */
    task_relation_t relation;        /* the q_task in force */
    task_relation_t blend_from;      /* the q_task that the present one is blended from */
    bool latched;
    bool settled; /* the loop's constants are those of the relation in force, which does not change any more */
    cooperation_loop_t loop;
    float forward_displacement_m; /* x_H - x_H0 in torso axes, scaled */
    vector3_t relation_m;         /* the relation's translation in torso axes: from the target to the virtual hand */
    pose_t target;                /* the latest */
} cooperation_t;

/* Initialisation of Algorithm 1. hand: q_H^E; robot: q_R^T. The relation being performed at this moment is what a blend
 * starts from. */
void cooperation_start(cooperation_t *self, const cooperation_config_t *config, const task_t *task, pose_t hand,
                       pose_t robot);

/* Another task from here on, the start poses kept. `blend` of cooperation_update() counts anew from 0. Releases a
 * latch. */
void cooperation_select(cooperation_t *self, const task_t *task);

/* Takes a new reference (clutch): the hand's displacement counts from `hand`, the robot's from `robot`, and the task
 * goes on where it was (`blend`, or latched), so that the next target is `robot`. */
void cooperation_clutch(cooperation_t *self, pose_t hand, pose_t robot, float blend);

/* Section V-B.3, at grasp: the q_task in force is stored and stays constant (the commanded relation). */
void cooperation_latch(cooperation_t *self);

/* The same with the relation that is being performed: conj(q_Rm) q_Hm, robot = q_Rm, which is the target then. */
void cooperation_latch_measured(cooperation_t *self, pose_t robot);

/* One pass of Algorithm 1's loop up to q_R^Tv = q_Hv^Tv conj(q_task): self->target, in the torso frame. blend within
 * 0..1: how far the way from `blend_from` to the task's own q_task is gone; 1 is the paper. */
void cooperation_update(cooperation_t *self, const pose_t *hand, float blend);

/* How the target of the last cooperation_update() moves while the hand does so, seen from the tracker. The motion of a
 * task that is coming into force is left out. */
twist_t cooperation_target_motion(const cooperation_t *self, const twist_t *hand);

#endif
