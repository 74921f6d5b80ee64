/* Reads the section `people` of a scenario file. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scenario_sections.h"

#define STEP_KEYS "do", "name", STEP_START_KEYS
#define MOVE_MAX_M 1.5
#define LONGEST_STEP_S 2e-3 /* largest physics step that --physics-step-us accepts */

/* The order must match person_action_t. */
static const char *const actions[] = {"rest", "move", "reach", "guide", "play", "grip", "release", "turn", NULL};

/* Keys of each action, in the order of actions[]. */
static const char *const action_keys[][16] = {
    {STEP_KEYS, "duration_s", NULL},
    {STEP_KEYS, "duration_s", "to_m", "by_m", "turn_deg", NULL},
    {STEP_KEYS, "duration_s", "to", "offset_m", "tolerance_m", "lift_m", NULL},
    {STEP_KEYS, "duration_s", "bring", "to", "offset_m", "tolerance_m", "lift_m", NULL},
    {STEP_KEYS, "recording", "axes", "position_scale", "rotation_scale", "from_s", "until_s", NULL},
    {STEP_KEYS, "object", NULL},
    {STEP_KEYS, NULL},
    {STEP_KEYS, "object", "turns", "duration_s", NULL},
};

static void read_move(yaml_reader_t *yaml, yaml_node_t *map, person_step_t *step) {
    double turn_deg[3] = {0.0, 0.0, 0.0};
    const bool to = yaml_find(yaml, map, "to_m") != NULL, by = yaml_find(yaml, map, "by_m") != NULL;
    if (to && by) {
        yaml_refuse(yaml, map, "to_m (from the start) or by_m (from here), not both");
    }
    if (!to && !by && yaml_find(yaml, map, "turn_deg") == NULL) {
        yaml_refuse(yaml, map, "a goal of the move: at least one of to_m, by_m and turn_deg");
    }
    step->from_here = !to;
    yaml_get_vector(yaml, map, to ? "to_m" : "by_m", 3, -MOVE_MAX_M, MOVE_MAX_M, step->displacement_m);
    yaml_get_vector(yaml, map, "turn_deg", 3, -180.0, 180.0, turn_deg);
    for (int k = 0; k < 3; k++) {
        step->rotation_vector_rad[k] = turn_deg[k] * ROBOT_RAD_PER_DEG;
    }
}

static void read_path(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, person_step_t *step) {
    step->tolerance_m = 0.003;
    step->to = scenario_point(yaml, yaml_need(yaml, map, "to"), self);
    if (step->action == PERSON_GUIDE) {
        step->what = scenario_point(yaml, yaml_need(yaml, map, "bring"), self);
    }
    yaml_get_vector(yaml, map, "offset_m", 3, -1.0, 1.0, step->offset_m);
    yaml_get_number(yaml, map, "tolerance_m", 0.0005, 0.1, &step->tolerance_m);
    yaml_get_number(yaml, map, "lift_m", 0.0, 0.5, &step->lift_m);
}

/* Reads the path of a recording, which is relative to the folder of the scenario file. */
static void read_recording_path(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, person_step_t *step) {
    const yaml_node_t *node = yaml_find(yaml, map, "recording");
    if (node == NULL) {
        return;
    }
    const char *path = yaml_scalar(node);
    const char *slash = strrchr(self->path, '/');
    const int folder = path[0] == '/' || slash == NULL ? 0 : (int)(slash + 1 - self->path);
    const int length = snprintf(step->recording, sizeof step->recording, "%.*s%s", folder, self->path, path);
    if (path[0] == '\0' || length >= (int)sizeof step->recording) {
        yaml_refuse(yaml, node, "the path of a CSV file, at most %d bytes including the folder of the scenario",
                    SCENARIO_PATH_BYTES - 1);
    }
}

static void read_play(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, person_step_t *step) {
    step->position_scale = step->rotation_scale = 1.0;
    read_recording_path(yaml, map, self, step);
    yaml_get_text(yaml, map, "axes", step->axes, sizeof step->axes);
    yaml_get_number(yaml, map, "position_scale", 0.0, 10.0, &step->position_scale);
    yaml_get_number(yaml, map, "rotation_scale", 0.0, 1.0, &step->rotation_scale);
    yaml_get_number(yaml, map, "from_s", 0.0, LONG_S, &step->from_s);
    yaml_get_number(yaml, map, "until_s", 0.0, LONG_S, &step->until_s);
    if (step->until_s > 0.0 && step->until_s <= step->from_s) {
        yaml_refuse(yaml, yaml_find(yaml, map, "until_s"), "more than from_s, which is %g", step->from_s);
    }
}

static void read_object(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, person_step_t *step) {
    const yaml_node_t *node = yaml_need(yaml, map, "object");
    step->object = scenario_object_index(yaml, node, self);
    const object_kind_t kind = self->object[step->object].kind;
    if (step->action == PERSON_TURN) {
        yaml_need_number(yaml, map, "turns", -100.0, 100.0, &step->turns);
    }
    if (yaml->failed) {
        return;
    }
    if (kind == OBJECT_STAND || (step->action == PERSON_TURN && kind != OBJECT_CRANK)) {
        yaml_refuse(yaml, node, "%s", step->action == PERSON_TURN ? "a crank" : "a rod or a crank");
    }
}

static void read_step(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, person_step_t *step) {
    const int action = yaml_word(yaml, yaml_need(yaml, map, "do"), actions);
    if (action < 0) {
        return;
    }
    step->action = (person_action_t)action;
    step->duration_s = 1.0;
    yaml_check_keys(yaml, map, action_keys[action]);
    yaml_get_name(yaml, map, "name", step->name, sizeof step->name);
    scenario_read_start(yaml, map, self, &step->start);
    if (step->action == PERSON_REST || step->action == PERSON_MOVE) {
        (void)yaml_need(yaml, map, "duration_s");
    }
    yaml_get_number(yaml, map, "duration_s", 0.01, LONG_S, &step->duration_s);
    switch (step->action) {
    case PERSON_REST:
    case PERSON_RELEASE: break;
    case PERSON_MOVE: read_move(yaml, map, step); break;
    case PERSON_REACH:
    case PERSON_GUIDE: read_path(yaml, map, self, step); break;
    case PERSON_PLAY: read_play(yaml, map, self, step); break;
    case PERSON_GRIP:
    case PERSON_TURN: read_object(yaml, map, self, step); break;
    }
}

/* Reads the steps. The number of steps was already checked when the steps' names were read. */
static void read_steps(yaml_reader_t *yaml, yaml_node_t *list, const scenario_t *self, person_step_t steps[],
                       size_t *count) {
    for (size_t i = 0; i < yaml_length(list) && !yaml->failed; i++) {
        read_step(yaml, yaml_item(yaml, list, i), self, &steps[(*count)++]);
    }
}

/* Sets the properties that a scenario file may omit. docs/scenario-files.md cites the sources of the numbers. */
static void set_defaults(person_t *person) {
    person->mass_kg = 1.0;
    person->stiffness_Npm = 350.0;
    person->damping_ratio = 0.7;
    person->stiffness_Nmprad = 5.0;
    person->grip_force_limit_N = 60.0;
    person->tremor_mm = 0.1;
}

/* Rejects a stiffness at which the hand would not come to rest. Spring and damper are evaluated once per step
 * (scene/hand_body.h). With w = sqrt(stiffness / inertia) and step h, the hand is therefore stable only if 4 *
 * damping_ratio * w h + (w h)^2 < 4 (Jury's criterion). */
static void check_is_stable(yaml_reader_t *yaml, yaml_node_t *map, const char *key, const person_t *person,
                            double stiffness, double inertia) {
    const double wh = 2.0 * (hypot(person->damping_ratio, 1.0) - person->damping_ratio);
    const double limit = inertia * (wh / LONGEST_STEP_S) * (wh / LONGEST_STEP_S);
    if (!yaml->failed && !(stiffness < limit)) {
        const yaml_node_t *node = yaml_find(yaml, map, key);
        yaml_refuse(yaml, node != NULL ? node : map,
                    "%s below %.3g, where a hand of %g kg and damping_ratio %g is stable", key, limit, person->mass_kg,
                    person->damping_ratio);
    }
}

static void read_person(yaml_reader_t *yaml, yaml_node_t *map, scenario_t *self, person_t *person) {
    static const char *const keys[] = {"tracked",
                                       "position_m",
                                       "rotation",
                                       "grip_m",
                                       "elbow_m",
                                       "mass_kg",
                                       "stiffness_Npm",
                                       "damping_ratio",
                                       "stiffness_Nmprad",
                                       "grip_force_limit_N",
                                       "tremor_mm",
                                       "cup",
                                       "program",
                                       "program_with_recording",
                                       NULL};
    set_defaults(person);
    yaml_check_keys(yaml, map, keys);
    (void)yaml_need(yaml, map, "position_m");
    scenario_read_pose(yaml, map, &person->start);
    yaml_get_bool(yaml, map, "tracked", &person->tracked);
    yaml_get_vector(yaml, map, "grip_m", 3, -0.3, 0.3, person->grip_m);
    const double to_elbow[3] = {0.0, 0.0, -0.3}; /* straight behind the hand */
    rotation_apply(person->start.rotation, to_elbow, person->elbow_m);
    for (int k = 0; k < 3; k++) {
        person->elbow_m[k] += person->start.position_m[k];
    }
    yaml_get_vector(yaml, map, "elbow_m", 3, -FAR_M, FAR_M, person->elbow_m);
    yaml_get_number(yaml, map, "mass_kg", 0.05, 20.0, &person->mass_kg);
    yaml_get_number(yaml, map, "stiffness_Npm", 10.0, 1e5, &person->stiffness_Npm);
    yaml_get_number(yaml, map, "damping_ratio", 0.0, 5.0, &person->damping_ratio);
    yaml_get_number(yaml, map, "stiffness_Nmprad", 0.01, 1e3, &person->stiffness_Nmprad);
    check_is_stable(yaml, map, "stiffness_Npm", person, person->stiffness_Npm, person->mass_kg);
    check_is_stable(yaml, map, "stiffness_Nmprad", person, person->stiffness_Nmprad,
                    person->mass_kg * PERSON_GYRATION_M * PERSON_GYRATION_M);
    yaml_get_number(yaml, map, "grip_force_limit_N", 0.01, 1e4, &person->grip_force_limit_N);
    yaml_get_number(yaml, map, "tremor_mm", 0.0, 20.0, &person->tremor_mm);
    scenario_read_cup(yaml, yaml_find(yaml, map, "cup"), &person->cup);
    read_steps(yaml, yaml_find(yaml, map, "program"), self, person->step, &person->step_count);
    read_steps(yaml, yaml_find(yaml, map, "program_with_recording"), self, person->recorded_step,
               &person->recorded_step_count);
    char event[EVENT_NAME_BYTES];
    (void)snprintf(event, sizeof event, "%s.done", person->name);
    person->done_event = events_find(&self->events, event);
}

void scenario_read_people(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *people = yaml_need(yaml, yaml_root(yaml), "people");
    size_t tracked = 0;
    for (size_t i = 0; i < self->person_count && !yaml->failed; i++) {
        person_t *person = &self->person[i];
        read_person(yaml, yaml_find(yaml, people, person->name), self, person);
        if (person->tracked) {
            self->tracked = i;
            tracked++;
        }
    }
    if (tracked != 1 && !yaml->failed) {
        yaml_refuse(yaml, people, "one person with tracked: true; there are %zu", tracked);
    }
}
