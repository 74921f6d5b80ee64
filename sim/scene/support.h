/* What keeps a rod from falling when nobody holds it: a stand with a V groove that fits the rod as it lies at the
 * start, and the ground. Elastic contacts with Coulomb friction, solved by ODE. */
#ifndef COMANIP_SIM_SUPPORT_H
#define COMANIP_SIM_SUPPORT_H

#include "objects.h"

struct dxJointGroup;

/* Contacts for the coming step between the rods and everything that is fixed, into `group` (emptied by the caller). */
void support_collide(struct dxWorld *world, struct dxJointGroup *group, const scene_object_t objects[], size_t count,
                     double step_s);

#endif
