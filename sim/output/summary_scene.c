#include "summary_scene.h"

#include <math.h>
#include <stdlib.h>

#define MM_PER_M 1e3
#define VEC8_PARTS 8

/* ---- setting */

/* Writes the path of the recording, and the scales of the first step that plays a recording. */
static void write_recording(json_writer_t *json, const char *key, const char *path, const person_t *person) {
    if (path == NULL) {
        json_null(json, key);
        return;
    }
    json_begin(json, key, '{');
    json_text(json, "file", path);
    for (size_t i = 0; i < person->recorded_step_count; i++) {
        const person_step_t *step = &person->recorded_step[i];
        if (step->action == PERSON_PLAY) {
            json_number(json, "position_scale", step->position_scale);
            json_number(json, "rotation_scale", step->rotation_scale);
            break;
        }
    }
    json_end(json, '}');
}

static void write_vec8(json_writer_t *json, const char *key, const float value[VEC8_PARTS]) {
    json_begin(json, key, '[');
    for (int i = 0; i < VEC8_PARTS; i++) {
        json_number(json, NULL, (double)value[i]);
    }
    json_end(json, ']');
}

void summary_write_setting(json_writer_t *json, const world_t *world) {
    const scenario_t *scenario = world->scenario;
    const float *parameter = world->observer.parameter;
    const bool is_torso = (int)parameter[PARAMETER_ERROR_FRAME] == ERROR_FRAME_TORSO;
    const size_t second = scenario->person_count > 1 ? 1 - scenario->tracked : scenario->tracked;
    write_recording(json, "recording", world->options->tracker_path, &scenario->person[scenario->tracked]);
    write_recording(json, "second_recording", world->options->second_path, &scenario->person[second]);
    json_begin(json, "law", '{');
    json_text(json, "error_frame", is_torso ? "torso" : "target");
    write_vec8(json, "gain_per_s", &parameter[PARAMETER_GAIN_PER_S]);
    write_vec8(json, "weight", &parameter[PARAMETER_WEIGHT]);
    json_end(json, '}');
}

/* ---- scene */

static void write_force(json_writer_t *json, const held_force_t *force) {
    json_number(json, "force_rms_N", held_force_rms_N(force));
    json_number(json, "force_peak_N", held_force_peak_N(force));
}

static void write_people(json_writer_t *json, const world_t *world) {
    json_begin(json, "people", '[');
    for (size_t i = 0; i < world->scenario->person_count; i++) {
        json_begin(json, NULL, '{');
        json_text(json, "name", world->scenario->person[i].name);
        write_force(json, &world->contact_monitor.hand[i]);
        json_end(json, '}');
    }
    json_end(json, ']');
    json_begin(json, "gripper", '{');
    write_force(json, &world->contact_monitor.gripper);
    json_end(json, '}');
}

static void write_least(json_writer_t *json, const proximity_t *proximity, const least_clearance_t *least,
                        const char *mm, const char *pair, const char *t_s) {
    const bool has_pair = least->pair >= 0;
    json_number(json, mm, MM_PER_M * least->least_m);
    if (has_pair) {
        json_text(json, pair, proximity_pair_name(proximity, least->pair));
    } else {
        json_null(json, pair);
    }
    json_number(json, t_s, has_pair ? least->t_s : (double)NAN);
}

static void write_clearance(json_writer_t *json, const world_t *world) {
    const contact_monitor_t *monitor = &world->contact_monitor;
    json_begin(json, "clearance", '{');
    write_least(json, world->proximity, &monitor->person, "person_mm", "person_pair", "person_t_s");
    write_least(json, world->proximity, &monitor->self, "self_mm", "self_pair", "self_t_s");
    json_number(json, "error_bound_mm", MM_PER_M * CONVEX_DISTANCE_ERROR_M);
    json_end(json, '}');
}

static void write_water(json_writer_t *json, const world_t *world) {
    const water_count_t *water = &world->state.water;
    if (world->scenario->water.particles == 0) {
        json_null(json, "water");
        return;
    }
    json_begin(json, "water", '{');
    json_number(json, "particles", world->scenario->water.particles);
    json_number(json, "poured", water->left_robot_cup);
    json_number(json, "in_robot_cup", water->in_robot_cup);
    json_number(json, "in_person_cup", water->in_person_cup);
    json_number(json, "elsewhere", water->elsewhere);
    json_end(json, '}');
}

/* ---- objects and cups of the trace */

static void write_vector(json_writer_t *json, const char *key, const double value[3]) {
    json_begin(json, key, '[');
    for (int k = 0; k < 3; k++) {
        json_number(json, NULL, value[k]);
    }
    json_end(json, ']');
}

static void write_cup(json_writer_t *json, const char *columns, const cup_t *cup) {
    static const double to_opening[3] = {0.0, 0.0, 1.0};
    double axis[3];
    if (!cup->present) {
        return;
    }
    rotation_apply(cup->mount.rotation, to_opening, axis);
    json_begin(json, NULL, '{');
    json_text(json, "columns", columns);
    json_number(json, "radius_m", cup->radius_m);
    json_number(json, "height_m", cup->height_m);
    write_vector(json, "mount_m", cup->mount.position_m);
    write_vector(json, "axis", axis);
    json_end(json, '}');
}

static void write_things(json_writer_t *json, const world_t *world) {
    static const char *const kinds[] = {[OBJECT_ROD] = "rod", [OBJECT_CRANK] = "crank", [OBJECT_STAND] = "stand"};
    const scenario_t *scenario = world->scenario;
    const int traced_object = world->state.traced_object;
    if (traced_object >= 0) {
        const object_t *object = &scenario->object[traced_object];
        json_begin(json, "object", '{');
        json_text(json, "name", object->name);
        json_text(json, "kind", kinds[object->kind]);
        json_number(json, "length_m", object->length_m);
        json_number(json, "radius_m", object->radius_m);
        json_end(json, '}');
    } else {
        json_null(json, "object");
    }
    json_begin(json, "cups", '[');
    write_cup(json, "hand", &scenario->cup);
    for (size_t i = 0; i < scenario->person_count; i++) {
        write_cup(json, i == scenario->tracked ? "person" : "second", &scenario->person[i].cup);
    }
    json_end(json, ']');
}

static int compare_times(const void *a, const void *b) {
    const event_t *const *x = a, *const *y = b;
    if ((*x)->first_s != (*y)->first_s) {
        return (*x)->first_s < (*y)->first_s ? -1 : 1;
    }
    return *x < *y ? -1 : *x > *y; /* simultaneous events keep the order of their declaration */
}

static void write_events(json_writer_t *json, const events_t *events) {
    const event_t *happened[EVENTS_MAX];
    size_t count = 0;
    for (size_t i = 0; i < events->count; i++) {
        if (events->event[i].times > 0) {
            happened[count++] = &events->event[i];
        }
    }
    qsort(happened, count, sizeof happened[0], compare_times);
    json_begin(json, "events", '[');
    for (size_t i = 0; i < count; i++) {
        json_begin(json, NULL, '{');
        json_number(json, "t_s", happened[i]->first_s);
        json_text(json, "name", happened[i]->name);
        if (happened[i]->times > 1) {
            json_number(json, "times", happened[i]->times);
        }
        json_end(json, '}');
    }
    json_end(json, ']');
}

void summary_write_scene(json_writer_t *json, const world_t *world) {
    write_people(json, world);
    write_clearance(json, world);
    write_water(json, world);
    write_events(json, &world->events);
    write_things(json, world);
}
