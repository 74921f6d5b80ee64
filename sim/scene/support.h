/* Supports rods that nobody holds: a stand with a V groove that fits the rod's start pose, and the ground. The contacts
 * are elastic with Coulomb friction and are solved by ODE. */
#ifndef COMANIP_SIM_SUPPORT_H
#define COMANIP_SIM_SUPPORT_H

#include "objects.h"

struct dxJointGroup;

/* Adds the contacts of the next step between the rods and all fixed bodies to `group`, which the caller empties. */
void support_collide(struct dxWorld *world, struct dxJointGroup *group, const scene_object_t objects[], size_t count,
                     double step_s);

#endif
