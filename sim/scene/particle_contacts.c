#include "particle_contacts.h"

#include <math.h>

/* ---- between particles */

/* Updates the positions in the sorted list, and removes from it the particles spilt since the last step. Returns the
 * number of particles left in the list. */
static int refresh(const particle_t particle[], particle_along_x_t sorted[], int sorted_count) {
    int kept = 0;
    for (int i = 0; i < sorted_count; i++) {
        const int index = sorted[i].particle;
        const particle_t *seen = &particle[index];
        if (!seen->is_spilt) {
            sorted[kept++] = (particle_along_x_t){
                {seen->position_m[0], seen->position_m[1], seen->position_m[2]}, seen->radius_m, index};
        }
    }
    return kept;
}

/* Uses insertion sort, which is fast here, because the order hardly changes from step to step. */
static void sort_along_x(particle_along_x_t sorted[], int count) {
    for (int i = 1; i < count; i++) {
        const particle_along_x_t moved = sorted[i];
        int k = i;
        for (; k > 0 && sorted[k - 1].position_m[0] > moved.position_m[0]; k--) {
            sorted[k] = sorted[k - 1];
        }
        sorted[k] = moved;
    }
}

static int touch(const particle_along_x_t *a, const particle_along_x_t *b, particle_contact_t *contact) {
    const double x = a->position_m[0] - b->position_m[0];
    const double y = a->position_m[1] - b->position_m[1];
    const double z = a->position_m[2] - b->position_m[2];
    const double reach_m = a->radius_m + b->radius_m;
    const double square = x * x + y * y + z * z;
    if (square >= reach_m * reach_m || square <= 0.0) {
        return 0;
    }
    const bool a_is_one = a->particle > b->particle;
    const double distance_m = sqrt(square);
    const double per_m = (a_is_one ? 1.0 : -1.0) / distance_m;
    *contact = (particle_contact_t){.one = a_is_one ? a->particle : b->particle,
                                    .other = a_is_one ? b->particle : a->particle,
                                    .normal = {x * per_m, y * per_m, z * per_m},
                                    .depth_m = reach_m - distance_m};
    return 1;
}

/* Tests only pairs that are close along x ("sweep and prune"). */
int particle_contacts_find(const particle_t particle[], particle_along_x_t sorted[], int *sorted_count,
                           particle_contact_t contact[]) {
    const int count = refresh(particle, sorted, *sorted_count);
    double largest_m = 0.0;
    int found = 0;
    *sorted_count = count;
    sort_along_x(sorted, count);
    for (int i = 0; i < count; i++) {
        largest_m = fmax(largest_m, sorted[i].radius_m);
    }
    for (int i = 0; i < count; i++) {
        const double from_m = sorted[i].position_m[0] - sorted[i].radius_m - largest_m;
        for (int k = i - 1; k >= 0 && sorted[k].position_m[0] > from_m; k--) {
            found += touch(&sorted[i], &sorted[k], &contact[found]);
        }
    }
    return found;
}

/* ---- with a cup */

static particle_contact_t at_wall(int particle, int wall, const cup_contact_t *touch, const placed_cup_t *before,
                                  const placed_cup_t *after, double step_s) {
    particle_contact_t contact = {.one = particle, .other = wall, .depth_m = touch->depth_m};
    double from_m[3], to_m[3];
    cup_to_world(before, touch->point_m, from_m);
    cup_to_world(after, touch->point_m, to_m);
    cup_rotate_to_world(before, touch->normal, contact.normal);
    for (int k = 0; k < 3; k++) {
        contact.wall_speed_mps += contact.normal[k] * (to_m[k] - from_m[k]) / step_s;
    }
    return contact;
}

int particle_contacts_find_cup(const particle_t particle[], int count, const placed_cup_t *before,
                               const placed_cup_t *after, double step_s, int first_wall, particle_contact_t contact[]) {
    int found = 0;
    for (int i = 0; i < count; i++) {
        cup_contact_t touch[CUP_MAX_CONTACTS];
        double in_cup_m[3];
        cup_from_world(before, particle[i].position_m, in_cup_m);
        const int touches = particle[i].is_spilt ? 0 : cup_touch(before->cup, in_cup_m, particle[i].radius_m, touch);
        for (int k = 0; k < touches; k++) {
            contact[found++] = at_wall(i, first_wall + k, &touch[k], before, after, step_s);
        }
    }
    return found;
}
