/* A person's hand as a rigid body with six degrees of freedom. The hand follows the desired pose. External forces
 * deflect the hand against the stiffness and damping of the arm and of the wrist. The person carries the hand's weight.
 *
 * In each step the force on the body is m (v_next - v_last) / h + K (x_aim - x) + D (v_last - v), where x_aim is the
 * desired position, and v_last and v_next are the desired velocities in the last step and in this step. The torque is
 * computed likewise. Without external forces the hand therefore follows the desired path exactly. According to the
 * neuromuscular literature, the arm's stiffness at the hand is 100 to 800 N/m (Mussa-Ivaldi, Hogan and Bizzi,
 * J. Neuroscience 5, 1985). */
#ifndef COMANIP_SIM_HAND_BODY_H
#define COMANIP_SIM_HAND_BODY_H

#include "../common/rigid_pose.h"
#include "../scenario/scenario.h"

struct dxBody;
struct dxWorld;

typedef struct {
    struct dxBody *body;
    double mass_kg, inertia_kgm2; /* inertia of a homogeneous ball with 60 mm radius of gyration */
    double stiffness_Npm, damping_Nspm;
    double stiffness_Nmprad, damping_Nmspprad;
    rigid_pose_t aim;                              /* desired pose at the end of the last step */
    rigid_pose_t next_aim;                         /* desired pose at the end of the next step */
    double aim_velocity_mps[3], aim_spin_radps[3]; /* average over the last step */
} hand_body_t;

void hand_body_init(hand_body_t *self, struct dxWorld *world, const person_t *person);

/* Applies the force and torque of this step to the body. */
void hand_body_push(hand_body_t *self, double step_s);

void hand_body_pose(const hand_body_t *self, rigid_pose_t *pose);

#endif
