#include "support.h"

#include <math.h>
#include <ode/ode.h>

#define FRICTION 0.6
/* Stiffness and damping of each contact, similar to those of rubber pads. A rod of 0.1 kg sinks in by about 0.01 mm and
 * does not bounce. */
#define CONTACT_NPM 2e4
#define CONTACT_NSPM 20.0
/* A contact creeps at 1 mm/s per N of friction. The four contacts of a rod in a groove constrain more directions than
 * the rod has degrees of freedom. Without creep the friction forces would be undetermined, and ODE's LCP solver would
 * fail. */
#define CONTACT_SLIP_MPNS 1e-3
#define GROOVE_DEPTH_M 0.01 /* a rod displaced downwards or sideways by more than this has left the groove */
#define GROOVE_SLOPE 0.70710678118654752440 /* sine and cosine of the 45-degree slope of the V's sides */

/* World and group to which contacts are added, and length of the step in which they act. */
typedef struct {
    dWorldID world;
    dJointGroupID group;
    double step_s;
} contact_sink_t;

/* Adds one contact. ODE limits two components of the friction separately, one parallel to `along` and one perpendicular
 * to it. This is right for a rod that slides along its axis. */
static void add_contact(const contact_sink_t *sink, dBodyID body, const double position_m[3], const double normal[3],
                        const double along[3], double depth_m) {
    const double total = sink->step_s * CONTACT_NPM + CONTACT_NSPM;
    dContact contact = {.surface = {.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM | dContactSlip1 |
                                            dContactSlip2 | dContactFDir1,
                                    .mu = FRICTION,
                                    .soft_erp = sink->step_s * CONTACT_NPM / total,
                                    .soft_cfm = 1.0 / total,
                                    .slip1 = CONTACT_SLIP_MPNS,
                                    .slip2 = CONTACT_SLIP_MPNS},
                        .geom = {.depth = depth_m}};
    for (int k = 0; k < 3; k++) {
        contact.geom.pos[k] = position_m[k];
        contact.geom.normal[k] = normal[k];
        contact.fdir1[k] = along[k];
    }
    dJointAttach(dJointCreateContact(sink->world, sink->group, &contact), body, NULL);
}

/* Computes the section of the rod's axis that was above the stand at the start, measured from the rod's centre. Returns
 * false if the rod did not lie on the stand. */
static bool resting_section(const object_t *rod, const object_t *stand, double *from_m, double *until_m) {
    const rigid_pose_t to_stand = rigid_pose_inverse(&stand->pose);
    const rigid_pose_t seen = rigid_pose_multiply(&to_stand, &rod->pose);
    const double z[3] = {0.0, 0.0, 1.0};
    double axis[3];
    rotation_apply(seen.rotation, z, axis);
    *from_m = -0.5 * rod->length_m;
    *until_m = 0.5 * rod->length_m;
    for (int k = 0; k < 2; k++) {
        const double half_m = 0.5 * stand->size_m[k], centre_m = seen.position_m[k];
        if (fabs(axis[k]) < 1e-6) {
            if (fabs(centre_m) > half_m) {
                return false;
            }
        } else {
            const double a = (-half_m - centre_m) / axis[k], b = (half_m - centre_m) / axis[k];
            *from_m = fmax(*from_m, fmin(a, b));
            *until_m = fmin(*until_m, fmax(a, b));
        }
    }
    const double gap_m = seen.position_m[2] - 0.5 * stand->size_m[2] - rod->radius_m;
    return *from_m < *until_m && fabs(gap_m) < GROOVE_DEPTH_M;
}

/* Computes the point at which the rod's axis now crosses the plane that is perpendicular to the groove and contains
 * `edge_m`. Returns false if the axis does not cross the plane. */
static bool axis_at_edge(const scene_object_t *rod, const double edge_m[3], const double along_groove[3],
                         double crossing_m[3]) {
    double centre[3], ahead[3], gap_m = 0.0, cosine = 0.0;
    scene_object_point(rod, 0.0, centre);
    scene_object_point(rod, 1.0, ahead);
    for (int k = 0; k < 3; k++) {
        gap_m += along_groove[k] * (edge_m[k] - centre[k]);
        cosine += along_groove[k] * (ahead[k] - centre[k]);
    }
    if (fabs(gap_m) > 0.5 * rod->data->length_m * fabs(cosine)) {
        return false;
    }
    scene_object_point(rod, cosine != 0.0 ? gap_m / cosine : 0.0, crossing_m);
    return true;
}

/* Adds contacts with the two sides of the V at one end of the groove. along_m: distance from the rod's centre to the
 * point of its axis that was above this end at the start. */
static void collide_groove(const contact_sink_t *sink, const scene_object_t *rod, const object_t *stand,
                           double along_m) {
    const double z[3] = {0.0, 0.0, 1.0};
    const double start_along[3] = {0.0, 0.0, along_m};
    double axis[3], up[3], edge[3], now[3];
    rotation_apply(rod->data->pose.rotation, z, axis);
    rotation_apply(stand->pose.rotation, z, up);
    rotation_apply(rod->data->pose.rotation, start_along, edge);
    for (int k = 0; k < 3; k++) {
        edge[k] += rod->data->pose.position_m[k];
    }
    if (!axis_at_edge(rod, edge, axis, now)) {
        return;
    }
    const double side[3] = {up[1] * axis[2] - up[2] * axis[1], up[2] * axis[0] - up[0] * axis[2],
                            up[0] * axis[1] - up[1] * axis[0]};
    double aside_m = 0.0;
    for (int k = 0; k < 3; k++) {
        aside_m += side[k] * (now[k] - edge[k]);
    }
    if (fabs(aside_m) > GROOVE_DEPTH_M) {
        return; /* beside the stand */
    }
    for (int sign = -1; sign <= 1; sign += 2) {
        double normal[3], position[3], depth_m = 0.0;
        for (int k = 0; k < 3; k++) {
            normal[k] = GROOVE_SLOPE * (up[k] + sign * side[k]);
            depth_m -= normal[k] * (now[k] - edge[k]);
        }
        for (int k = 0; k < 3; k++) {
            position[k] = now[k] - rod->data->radius_m * normal[k];
        }
        if (depth_m >= 0.0 && depth_m < GROOVE_DEPTH_M) {
            add_contact(sink, rod->body, position, normal, axis, depth_m);
        }
    }
}

static void collide_ground(const contact_sink_t *sink, const scene_object_t *rod) {
    const double x[3] = {1.0, 0.0, 0.0}, up[3] = {0.0, 0.0, 1.0};
    for (int end = -1; end <= 1; end += 2) {
        double position[3];
        scene_object_point(rod, 0.5 * end * rod->data->length_m, position);
        position[2] -= rod->data->radius_m;
        if (position[2] < OBJECTS_GROUND_Z_M) {
            add_contact(sink, rod->body, position, up, x, OBJECTS_GROUND_Z_M - position[2]);
        }
    }
}

void support_collide(dWorldID world, dJointGroupID group, const scene_object_t objects[], size_t count, double step_s) {
    const contact_sink_t sink = {world, group, step_s};
    for (size_t i = 0; i < count; i++) {
        if (objects[i].data->kind != OBJECT_ROD) {
            continue;
        }
        collide_ground(&sink, &objects[i]);
        for (size_t j = 0; j < count; j++) {
            double from_m, until_m;
            if (objects[j].data->kind == OBJECT_STAND &&
                resting_section(objects[i].data, objects[j].data, &from_m, &until_m)) {
                collide_groove(&sink, &objects[i], objects[j].data, from_m);
                collide_groove(&sink, &objects[i], objects[j].data, until_m);
            }
        }
    }
}
