/* Reads the section `objects` of a scenario file. */
#include "scenario_sections.h"

#define COMMON_KEYS "kind", "position_m", "rotation"
#define HELD_KEYS "length_m", "radius_m", "mass_kg", "robot_grip", "person_grip", "points"

static grip_kind_t read_grip(yaml_reader_t *yaml, yaml_node_t *map, const char *key) {
    static const char *const grips[] = {"fixed", "ball", NULL};
    const yaml_node_t *node = yaml_find(yaml, map, key);
    return node != NULL && yaml_word(yaml, node, grips) == 1 ? GRIP_BALL : GRIP_FIXED;
}

/* Reads the positions of the points. Their names are already known (scenario_names.c). */
static void read_points(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    yaml_node_t *points = yaml_find(yaml, map, "points");
    for (size_t i = 0; i < object->point_count; i++) {
        const yaml_node_t *along = yaml_find(yaml, points, object->point[i].name);
        object->point[i].along_m = yaml_number(yaml, along, "m", -0.5 * object->length_m, 0.5 * object->length_m);
    }
}

/* Reads the keys of objects that a hand can hold: a rod or a crank's handle. */
static void read_held(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    yaml_need_number(yaml, map, "length_m", 0.01, FAR_M, &object->length_m);
    yaml_need_number(yaml, map, "radius_m", 0.001, 1.0, &object->radius_m);
    yaml_need_number(yaml, map, "mass_kg", 0.001, 20.0, &object->mass_kg);
    object->robot_grip = read_grip(yaml, map, "robot_grip");
    object->person_grip = read_grip(yaml, map, "person_grip");
    read_points(yaml, map, object);
}

static void read_rod(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const keys[] = {COMMON_KEYS, HELD_KEYS, "held_by", NULL};
    static const char *const holders[] = {"robot", NULL};
    yaml_check_keys(yaml, map, keys);
    read_held(yaml, map, object);
    const yaml_node_t *holder = yaml_find(yaml, map, "held_by");
    object->held_by_robot = holder != NULL && yaml_word(yaml, holder, holders) == 0;
}

static void read_crank(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const keys[] = {COMMON_KEYS, HELD_KEYS, "damping_Nmspprad", "friction_Nm", NULL};
    yaml_check_keys(yaml, map, keys);
    read_held(yaml, map, object);
    yaml_get_number(yaml, map, "damping_Nmspprad", 0.0, 100.0, &object->damping_Nmspprad);
    yaml_get_number(yaml, map, "friction_Nm", 0.0, 100.0, &object->friction_Nm);
}

static void read_stand(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const keys[] = {COMMON_KEYS, "size_m", NULL};
    yaml_check_keys(yaml, map, keys);
    yaml_need_vector(yaml, map, "size_m", 3, 0.001, FAR_M, object->size_m);
}

static void read_object(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const kinds[] = {"rod", "crank", "stand", NULL}; /* in the order of object_kind_t */
    const int kind = yaml_word(yaml, yaml_need(yaml, map, "kind"), kinds);
    if (kind < 0) {
        return;
    }
    object->kind = (object_kind_t)kind;
    (void)yaml_need(yaml, map, "position_m");
    scenario_read_pose(yaml, map, &object->pose);
    switch (object->kind) {
    case OBJECT_ROD: read_rod(yaml, map, object); break;
    case OBJECT_CRANK: read_crank(yaml, map, object); break;
    case OBJECT_STAND: read_stand(yaml, map, object); break;
    }
}

void scenario_read_objects(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *objects = yaml_find(yaml, yaml_root(yaml), "objects");
    for (size_t i = 0; i < self->object_count && !yaml->failed; i++) {
        read_object(yaml, yaml_find(yaml, objects, self->object[i].name), &self->object[i]);
    }
}
