/* Supports that a rod lies on when nobody holds it: the ground, or a stand with a V groove that fits the rod's start
 * pose. The contacts are elastic, have Coulomb friction, and are solved by ODE. */
#ifndef COMANIP_SIM_SUPPORT_H
#define COMANIP_SIM_SUPPORT_H

#include "objects.h"

struct dxJointGroup;

/* Adds to `group` the contacts of the next step between the rods and all fixed bodies. The caller must empty the group
 * after the step. */
void support_collide(struct dxWorld *world, struct dxJointGroup *group, const scene_object_t objects[], size_t count,
                     double step_s);

#endif
