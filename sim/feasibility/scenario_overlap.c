/* Checks that no two bodies overlap at the start. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../proximity/bodies.h"
#include "../proximity/convex_overlap.h"
#include "comanip_schema.h"
#include "scenario_geometry.h"

#define CONTACT_M 0.001 /* overlap that still counts as contact, for example of a rod with its stand */
#define SOLIDS_MAX (SCENARIO_MAX_OBJECTS + BODIES_ROBOT_PARTS + SCENARIO_MAX_PEOPLE * BODIES_PERSON_PARTS)
#define NAME_BYTES 80
#define KEY_BYTES 100

typedef enum {
    SOLID_OBJECT,
    SOLID_ROBOT_CUP,
    SOLID_PERSON_CUP,
    SOLID_PERSON,    /* a person's hand and forearm */
    SOLID_FOREARM,   /* the robot's forearm and gripper; objects may overlap them, so that they can be gripped */
    SOLID_UPPER_ARM, /* the robot's upper arm and shoulder */
    SOLID_BODY,      /* the robot's torso and head */
} solid_kind_t;

#define BIT(kind) (1u << (kind))
#define ROBOT (BIT(SOLID_FOREARM) | BIT(SOLID_UPPER_ARM) | BIT(SOLID_BODY))

/* For each kind, the kinds that it must not overlap. Each pair is listed once. A person's hand and forearm may overlap
 * objects, because the person may grip any object. */
static const unsigned must_not_overlap[] = {
    [SOLID_OBJECT] =
        BIT(SOLID_OBJECT) | BIT(SOLID_ROBOT_CUP) | BIT(SOLID_PERSON_CUP) | BIT(SOLID_UPPER_ARM) | BIT(SOLID_BODY),
    [SOLID_ROBOT_CUP] = BIT(SOLID_PERSON_CUP) | BIT(SOLID_UPPER_ARM) | BIT(SOLID_BODY),
    [SOLID_PERSON_CUP] = BIT(SOLID_PERSON_CUP) | ROBOT,
    [SOLID_PERSON] = BIT(SOLID_ROBOT_CUP) | ROBOT,
    [SOLID_FOREARM] = BIT(SOLID_BODY),
    [SOLID_UPPER_ARM] = 0,
    [SOLID_BODY] = 0,
};

typedef struct {
    convex_shape_t shape;
    solid_kind_t kind;
    char name[NAME_BYTES];
    char key[KEY_BYTES]; /* key in the scenario file that sets the solid's position */
    const double *value; /* value of that key */
    size_t value_count;
} solid_t;

typedef struct {
    solid_t solid[SOLIDS_MAX];
    size_t count;
} solids_t;

static solid_t *add(solids_t *self, const convex_shape_t *shape, solid_kind_t kind, const double value[],
                    size_t count) {
    solid_t *solid = &self->solid[self->count++];
    *solid = (solid_t){.shape = *shape, .kind = kind, .value = value, .value_count = count};
    return solid;
}

static void add_object(solids_t *self, const object_t *object) {
    convex_shape_t shape = {
        .kind = SHAPE_CYLINDER, .length_m = object->length_m, .radius_m = object->radius_m, .pose = object->pose};
    if (object->kind == OBJECT_STAND) {
        shape = (convex_shape_t){.kind = SHAPE_BOX,
                                 .pose = object->pose,
                                 .size_m = {object->size_m[0], object->size_m[1], object->size_m[2]}};
    } else if (object->kind == OBJECT_CRANK) {
        const rigid_pose_t offset = {{object->radius_m, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
        shape.radius_m = OBJECT_HANDLE_RADIUS_M;
        shape.pose = rigid_pose_multiply(&object->pose, &offset);
    }
    convex_shape_finish(&shape);
    solid_t *solid = add(self, &shape, SOLID_OBJECT, object->pose.position_m, 3);
    (void)snprintf(solid->name, sizeof solid->name, "%s", object->name);
    (void)snprintf(solid->key, sizeof solid->key, "objects.%s.position_m", object->name);
}

static solid_kind_t robot_kind(robot_part_t part) {
    switch (part) {
    case ROBOT_PART_CUP: return SOLID_ROBOT_CUP;
    case ROBOT_PART_UPPER_ARM:
    case ROBOT_PART_SHOULDER: return SOLID_UPPER_ARM;
    case ROBOT_PART_TORSO:
    case ROBOT_PART_HEAD: return SOLID_BODY;
    default: return SOLID_FOREARM;
    }
}

/* Adds the parts of the robot, but not the object that it holds, which add_object() adds. */
static void add_robot(solids_t *self, const scenario_t *scenario, const bodies_t *bodies) {
    static const char *const names[] = {COMANIP_CLEARANCE_ROBOT_PART_NAMES};
    for (int i = 0; i < BODIES_ROBOT_PARTS; i++) {
        if (i == ROBOT_PART_HELD || !bodies->robot[i].present) {
            continue;
        }
        const bool is_cup = i == ROBOT_PART_CUP;
        const solid_kind_t kind = robot_kind((robot_part_t)i);
        const double *value = is_cup ? scenario->cup.mount.position_m : scenario->start_deg;
        solid_t *solid = add(self, &bodies->robot[i].shape, kind, value, is_cup ? 3 : ROBOT_JOINTS);
        (void)snprintf(solid->name, sizeof solid->name, "the robot's %s", names[i]);
        (void)snprintf(solid->key, sizeof solid->key, "%s", is_cup ? "robot.cup.mount_m" : "arm.start_deg");
    }
}

static void add_person(solids_t *self, const person_t *person, const body_t bodies[BODIES_PERSON_PARTS]) {
    static const char *const names[] = {COMANIP_CLEARANCE_PERSON_PART_NAMES};
    for (int i = 0; i < BODIES_PERSON_PARTS; i++) {
        if (i == PERSON_PART_HELD || !bodies[i].present) {
            continue;
        }
        const bool is_cup = i == PERSON_PART_CUP;
        const double *value = is_cup ? person->cup.mount.position_m : person->start.position_m;
        solid_t *solid = add(self, &bodies[i].shape, is_cup ? SOLID_PERSON_CUP : SOLID_PERSON, value, 3);
        (void)snprintf(solid->name, sizeof solid->name, "%s's %s", person->name, names[i]);
        (void)snprintf(solid->key, sizeof solid->key, "people.%s.%s", person->name,
                       is_cup ? "cup.mount_m" : "position_m");
    }
}

static double overlap_m(const solid_t *a, const solid_t *b) {
    const bool are_far = body_distance_m(a->shape.pose.position_m, b->shape.pose.position_m) >
                         a->shape.bounding_radius_m + b->shape.bounding_radius_m;
    return are_far ? 0.0 : convex_overlap_m(&a->shape, &b->shape);
}

static void refuse(const scenario_t *scenario, const solid_t *a, const solid_t *b, double overlap, char error[],
                   size_t error_size) {
    char value[NAME_BYTES] = "";
    for (size_t i = 0; i < a->value_count; i++) {
        const size_t used = strlen(value);
        (void)snprintf(value + used, sizeof value - used, "%s%g", i > 0 ? ", " : "", a->value[i]);
    }
    (void)snprintf(error, error_size, "%s: %s '[%s]': expected no overlap; %s is %.1f mm inside %s", scenario->path,
                   a->key, value, a->name, 1e3 * overlap, b->name);
}

static bool check_pairs(const solids_t *self, const scenario_t *scenario, char error[], size_t error_size) {
    for (size_t i = 0; i < self->count; i++) {
        for (size_t j = 0; j < self->count; j++) {
            const solid_t *a = &self->solid[i], *b = &self->solid[j];
            if ((must_not_overlap[a->kind] & BIT(b->kind)) == 0 || (a->kind == b->kind && i <= j)) {
                continue;
            }
            const double overlap = overlap_m(a, b);
            if (overlap > CONTACT_M) {
                refuse(scenario, a, b, overlap, error, error_size);
                return false;
            }
        }
    }
    return true;
}

/* Places the bodies in their start poses. The water is left out, because it is inside the cup and would take long
 * to settle. */
static bool place_bodies(bodies_t *bodies, const scenario_t *scenario) {
    scenario_t *dry = malloc(sizeof *dry);
    scene_t *scene = NULL;
    if (dry != NULL) {
        memcpy(dry, scenario, sizeof *dry);
        dry->water.particles = 0;
        scene = scene_create(dry, &dry->events);
    }
    const bool is_made = scene != NULL;
    if (is_made) {
        bodies_init(bodies, scenario);
        bodies_place(bodies, scenario, scene);
    }
    scene_destroy(scene);
    free(dry);
    return is_made;
}

bool scenario_check_overlap(const scenario_t *self, char error[], size_t error_size) {
    bodies_t bodies;
    if (!place_bodies(&bodies, self)) {
        (void)snprintf(error, error_size, "%s: not enough memory for its scene", self->path);
        return false;
    }
    solids_t solids = {.count = 0};
    for (size_t i = 0; i < self->object_count; i++) {
        add_object(&solids, &self->object[i]);
    }
    add_robot(&solids, self, &bodies);
    for (size_t i = 0; i < self->person_count; i++) {
        add_person(&solids, &self->person[i], bodies.person[i]);
    }
    return check_pairs(&solids, self, error, error_size);
}
