/* Section checks. */
#include <string.h>

#include "scenario_sections.h"

/* In the order of measure_t. */
static const char *const measures[] = {
    "settled_position", "following_rms", "displacement", "way_x", "way_y", "way_z", "tilt", "cup_tilt_peak", "turn",
    "water_poured", "water_caught", "flow_while_moving", "drops", "held", "force_rms", "force_peak", "turns",
    "carried_for", "clearance", "self_clearance", NULL,
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

/* A number of seconds, an event, or {event: NAME, plus_s: S}. */
static moment_t read_moment(yaml_reader_t *yaml, yaml_node_t *node, const char *key, const scenario_t *self) {
    static const char *const keys[] = {"event", "plus_s", NULL};
    moment_t moment = {EVENT_NONE, 0.0};
    if (yaml_is_mapping(node)) {
        yaml_check_keys(yaml, node, key, keys);
        moment.event = scenario_event_number(yaml, yaml_need(yaml, node, key, "event"), key, self);
        yaml_get_number(yaml, node, "plus_s", 0.0, LONG_S, &moment.s);
    } else if (strpbrk(yaml_text(yaml, node, key), "abcdfghijklmnopqrstuvwxyz") != NULL) {
        moment.event = scenario_event_number(yaml, node, key, self);
    } else {
        moment.s = yaml_number(yaml, node, key, 0.0, LONG_S);
    }
    return moment;
}

static void read_window(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, scenario_check_t *check) {
    yaml_node_t *from = yaml_find(yaml, map, "from"), *until = yaml_find(yaml, map, "until");
    if (from != NULL) {
        check->has_from = true;
        check->from = read_moment(yaml, from, "from", self);
    }
    if (until != NULL) {
        check->has_until = true;
        check->until = read_moment(yaml, until, "until", self);
    }
}

static void read_limit(yaml_reader_t *yaml, yaml_node_t *map, scenario_check_t *check) {
    const bool least = yaml_find(yaml, map, "at_least") != NULL, most = yaml_find(yaml, map, "at_most") != NULL;
    if (least == most) {
        yaml_refuse(yaml, map, check->name, "either at_least or at_most");
    }
    check->is_lower_bound = least;
    yaml_get_number(yaml, map, least ? "at_least" : "at_most", -1e6, 1e6, &check->limit);
}

static void read_check(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, scenario_check_t *check) {
    static const char *const keys[] = {"name", "measure", "from", "until", "expected_m", "expected_deg", "object", "by",
                                       "at_least", "at_most", NULL};
    yaml_check_keys(yaml, map, "check", keys);
    const yaml_node_t *name = yaml_need(yaml, map, "check", "name");
    yaml_copy_name(yaml, name, yaml_text(yaml, name, "name"), check->name, sizeof check->name);
    const yaml_node_t *word = yaml_need(yaml, map, "check", "measure");
    const int measure = yaml_word(yaml, word, "measure", measures);
    check->measure = measure >= 0 ? (measure_t)measure : MEASURE_TILT;
    read_window(yaml, map, self, check);
    read_limit(yaml, map, check);
    yaml_get_vector(yaml, map, "expected_m", 3, -1.5, 1.5, check->expected_m);
    yaml_get_number(yaml, map, "expected_deg", -360.0, 360.0, &check->expected_deg);
    check->person = self->tracked;
    if (needs_object(check->measure)) {
        check->object = scenario_object_number(yaml, yaml_need(yaml, map, check->name, "object"), "object", self);
    }
    if (yaml_find(yaml, map, "by") != NULL || needs_person(check->measure)) {
        check->person = scenario_person_number(yaml, yaml_need(yaml, map, check->name, "by"), "by", self);
    }
    if (needs_water(check->measure) && self->water.particles == 0) {
        yaml_refuse(yaml, word, "measure", "water in the scenario");
    }
    if (check->measure == MEASURE_CUP_TILT_PEAK && !self->cup.present) {
        yaml_refuse(yaml, word, "measure", "a cup on the robot's hand");
    }
    if (check->measure == MEASURE_TURNS && self->object[check->object].kind != OBJECT_CRANK) {
        yaml_refuse(yaml, yaml_find(yaml, map, "object"), "object", "a crank");
    }
}

void scenario_read_checks(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *list = yaml_find(yaml, yaml_root(yaml), "checks");
    if (list != NULL && !yaml_is_sequence(list)) {
        yaml_refuse(yaml, list, "checks", "a list of checks");
    }
    for (size_t i = 0; i < yaml_length(list); i++) {
        if (self->check_count == SCENARIO_MAX_CHECKS) {
            yaml_refuse(yaml, list, "checks", "at most 24 checks");
            return;
        }
        read_check(yaml, yaml_item(yaml, list, i), self, &self->check[self->check_count++]);
    }
}
