/* Reads the section `checks` of a scenario file. */
#include <ctype.h>
#include <string.h>

#include "scenario_sections.h"

/* The order must match measure_t. */
static const char *const measures[] = {
    "settled_position",
    "following_rms",
    "relation_rms",
    "displacement",
    "way_x",
    "way_y",
    "way_z",
    "tilt",
    "cup_tilt_peak",
    "turn",
    "water_poured",
    "water_caught",
    "flow_while_moving",
    "drops",
    "held",
    "force_rms",
    "force_peak",
    "turns",
    "carried_for",
    "clearance",
    "self_clearance",
    "aim",
    NULL,
};

static bool needs_object(measure_t measure) {
    return measure == MEASURE_DROPS || measure == MEASURE_HELD || measure == MEASURE_TURNS ||
           measure == MEASURE_CARRIED_FOR;
}

static bool needs_person(measure_t measure) {
    return measure == MEASURE_HELD || measure == MEASURE_FORCE_RMS || measure == MEASURE_FORCE_PEAK ||
           measure == MEASURE_CARRIED_FOR;
}

static bool needs_water(measure_t measure) {
    return measure == MEASURE_WATER_POURED || measure == MEASURE_WATER_CAUGHT || measure == MEASURE_FLOW_WHILE_MOVING;
}

static bool is_force(measure_t measure) {
    return measure == MEASURE_FORCE_RMS || measure == MEASURE_FORCE_PEAK;
}

static bool knows_person(measure_t measure) {
    return needs_person(measure) || measure == MEASURE_FLOW_WHILE_MOVING || measure == MEASURE_RELATION_RMS ||
           measure == MEASURE_AIM;
}

static bool needs_expected_m(measure_t measure) {
    return measure == MEASURE_DISPLACEMENT || measure == MEASURE_AIM;
}

/* Reads a moment: a number of seconds, an event, or {event: NAME, plus_s: S}. */
static moment_t read_moment(yaml_reader_t *yaml, yaml_node_t *node, const scenario_t *self) {
    static const char *const keys[] = {"event", "plus_s", NULL};
    moment_t moment = {EVENT_NONE, 0.0};
    if (yaml_is_mapping(node)) {
        yaml_check_keys(yaml, node, keys);
        moment.event = scenario_event_index(yaml, yaml_need(yaml, node, "event"), self);
        yaml_get_number(yaml, node, "plus_s", 0.0, LONG_S, &moment.s);
    } else if (isalpha((unsigned char)yaml_scalar(node)[0]) != 0) {
        moment.event = scenario_event_index(yaml, node, self);
    } else {
        moment.s = yaml_number(yaml, node, "s", 0.0, LONG_S);
    }
    return moment;
}

static void read_window(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, scenario_check_t *check) {
    yaml_node_t *from = yaml_find(yaml, map, "from"), *until = yaml_find(yaml, map, "until");
    if (from != NULL) {
        check->has_from = true;
        check->from = read_moment(yaml, from, self);
    }
    if (until != NULL) {
        check->has_until = true;
        check->until = read_moment(yaml, until, self);
    }
    if (from != NULL && until != NULL && check->from.event == check->until.event && check->until.s < check->from.s) {
        yaml_refuse(yaml, until, "a moment that is not before from");
    }
}

static void read_limit(yaml_reader_t *yaml, yaml_node_t *map, scenario_check_t *check) {
    const bool least = yaml_find(yaml, map, "at_least") != NULL, most = yaml_find(yaml, map, "at_most") != NULL;
    if (least == most) {
        yaml_refuse(yaml, map, "exactly one limit, at_least or at_most");
    }
    check->is_lower_bound = least;
    yaml_get_number(yaml, map, least ? "at_least" : "at_most", -1e6, 1e6, &check->limit);
}

/* Accepts only the keys that apply to this measure. */
static void check_keys(yaml_reader_t *yaml, yaml_node_t *map, measure_t measure) {
    const char *keys[12] = {"name", "measure", "from", "until", "at_least", "at_most"};
    size_t count = 6;
    if (needs_object(measure) || is_force(measure)) {
        keys[count++] = "object";
    }
    if (knows_person(measure)) {
        keys[count++] = "by";
    }
    if (needs_expected_m(measure)) {
        keys[count++] = "expected_m";
    }
    if (measure == MEASURE_TURN) {
        keys[count++] = "expected_deg";
    }
    yaml_check_keys(yaml, map, keys);
}

static void read_object(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self, scenario_check_t *check) {
    check->object = scenario_object_index(yaml, node, self);
    const object_kind_t kind = self->object[check->object].kind;
    const bool needs_crank = check->measure == MEASURE_TURNS;
    if (!yaml->failed && (kind == OBJECT_STAND || (needs_crank && kind != OBJECT_CRANK))) {
        yaml_refuse(yaml, node, "%s", needs_crank ? "a crank" : "a rod or a crank");
    }
}

/* Returns the index of the first object that a hand can hold. */
static size_t first_held(yaml_reader_t *yaml, const yaml_node_t *word, const scenario_t *self) {
    for (size_t i = 0; i < self->object_count; i++) {
        if (self->object[i].kind != OBJECT_STAND) {
            return i;
        }
    }
    yaml_refuse(yaml, word, "a rod or a crank among the objects");
    return 0;
}

static void read_subject(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, scenario_check_t *check) {
    check->person = self->tracked;
    if (yaml_find(yaml, map, "by") != NULL || needs_person(check->measure)) {
        check->person = scenario_person_index(yaml, yaml_need(yaml, map, "by"), self);
    }
    const yaml_node_t *node = yaml_find(yaml, map, "object");
    if (node == NULL && is_force(check->measure)) {
        check->object = first_held(yaml, yaml_find(yaml, map, "measure"), self);
    } else if (node != NULL || needs_object(check->measure)) {
        read_object(yaml, yaml_need(yaml, map, "object"), self, check);
    }
}

static bool has_cup(const scenario_t *self) {
    bool has = false;
    for (size_t i = 0; i < self->person_count; i++) {
        has = has || self->person[i].cup.present;
    }
    return has;
}

/* Rejects a measure that needs something that the scenario does not contain, such as water. */
static void check_scene(yaml_reader_t *yaml, const yaml_node_t *word, const scenario_t *self, measure_t measure) {
    if (needs_water(measure) && self->water.particles == 0) {
        yaml_refuse(yaml, word, "water in the scenario");
    }
    if (measure == MEASURE_WATER_CAUGHT && !has_cup(self)) {
        yaml_refuse(yaml, word, "a person with a cup");
    }
    if (measure == MEASURE_CUP_TILT_PEAK && !self->cup.present) {
        yaml_refuse(yaml, word, "a cup on the robot's hand");
    }
}

static void read_check(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, scenario_check_t *check) {
    const yaml_node_t *word = yaml_need(yaml, map, "measure");
    const int measure = yaml_word(yaml, word, measures);
    if (measure < 0) {
        return;
    }
    check->measure = (measure_t)measure;
    check_keys(yaml, map, check->measure);
    (void)yaml_need(yaml, map, "name");
    yaml_get_name(yaml, map, "name", check->name, sizeof check->name);
    read_window(yaml, map, self, check);
    read_limit(yaml, map, check);
    if (needs_expected_m(check->measure)) {
        yaml_need_vector(yaml, map, "expected_m", 3, -1.5, 1.5, check->expected_m);
    } else if (check->measure == MEASURE_TURN) {
        yaml_need_number(yaml, map, "expected_deg", 0.0, 180.0, &check->expected_deg);
    }
    read_subject(yaml, map, self, check);
    check_scene(yaml, word, self, check->measure);
}

static void refuse_repeated(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, size_t check) {
    for (size_t i = 0; i < check; i++) {
        if (strcmp(self->check[i].name, self->check[check].name) == 0) {
            yaml_refuse(yaml, yaml_find(yaml, map, "name"), "another name: an earlier check already has this name");
        }
    }
}

void scenario_read_checks(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *list = yaml_find(yaml, yaml_root(yaml), "checks");
    yaml_expect_list(yaml, list, SCENARIO_MAX_CHECKS);
    for (size_t i = 0; i < yaml_length(list) && !yaml->failed; i++) {
        yaml_node_t *map = yaml_item(yaml, list, i);
        read_check(yaml, map, self, &self->check[self->check_count++]);
        if (!yaml->failed) {
            refuse_repeated(yaml, map, self, i);
        }
    }
}
