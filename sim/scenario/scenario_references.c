/* Resolves the names that a scenario file refers to: objects, people, events, points. */
#include <stdio.h>
#include <string.h>

#include "scenario_sections.h"
#include "yaml_choice.h"

#define POINTS_MAX (SCENARIO_MAX_OBJECTS * SCENARIO_MAX_POINTS + SCENARIO_MAX_PEOPLE + 1)

/* Returns the index of the node's word in the NULL-terminated list, or 0 after an error. */
static int find(yaml_reader_t *yaml, const yaml_node_t *node, const char *what, const char *const words[]) {
    const int number = yaml_choice(yaml_scalar(node), words);
    if (number < 0 && node != NULL) {
        yaml_refuse_choice(yaml, node, what, words);
    }
    return number > 0 ? number : 0;
}

size_t scenario_object_index(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self) {
    const char *names[SCENARIO_MAX_OBJECTS + 1] = {NULL};
    for (size_t i = 0; i < self->object_count; i++) {
        names[i] = self->object[i].name;
    }
    return (size_t)find(yaml, node, "objects", names);
}

size_t scenario_person_index(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self) {
    const char *names[SCENARIO_MAX_PEOPLE + 1] = {NULL};
    for (size_t i = 0; i < self->person_count; i++) {
        names[i] = self->person[i].name;
    }
    return (size_t)find(yaml, node, "people", names);
}

int scenario_event_index(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self) {
    const char *names[EVENTS_MAX + 1] = {NULL};
    for (size_t i = 0; i < self->events.count; i++) {
        names[i] = self->events.event[i].name;
    }
    return find(yaml, node, "events", names);
}

/* Lists all points with their names: the gripper, the people's grips, the objects' points. */
static size_t list_points(const scenario_t *self, point_t points[POINTS_MAX],
                          char names[POINTS_MAX][2 * SCENARIO_NAME_BYTES]) {
    size_t count = 0;
    points[count] = (point_t){.kind = POINT_ROBOT_GRIPPER};
    (void)strcpy(names[count++], "robot.gripper");
    for (size_t i = 0; i < self->person_count; i++) {
        points[count] = (point_t){.kind = POINT_PERSON_GRIP, .index = i};
        (void)snprintf(names[count++], sizeof names[0], "%s.grip", self->person[i].name);
    }
    for (size_t i = 0; i < self->object_count; i++) {
        for (size_t j = 0; j < self->object[i].point_count; j++) {
            points[count] = (point_t){.kind = POINT_OBJECT, .index = i, .point = j};
            (void)snprintf(names[count++], sizeof names[0], "%s.%s", self->object[i].name,
                           self->object[i].point[j].name);
        }
    }
    return count;
}

point_t scenario_point(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self) {
    point_t points[POINTS_MAX];
    char names[POINTS_MAX][2 * SCENARIO_NAME_BYTES];
    const char *words[POINTS_MAX + 1] = {NULL};
    const size_t count = list_points(self, points, names);
    for (size_t i = 0; i < count; i++) {
        words[i] = names[i];
    }
    return points[find(yaml, node, "points", words)];
}

void scenario_read_start(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, step_start_t *start) {
    yaml_get_number(yaml, map, "at_s", 0.0, LONG_S, &start->at_s);
    yaml_get_number(yaml, map, "delay_s", 0.0, LONG_S, &start->delay_s);
    yaml_get_number(yaml, map, "patience_s", 0.0, LONG_S, &start->patience_s);
    yaml_node_t *after = yaml_find(yaml, map, "after");
    if (after == NULL) {
        return;
    }
    if (!yaml_is_list(after)) {
        start->awaited[start->awaited_count++] = scenario_event_index(yaml, after, self);
        return;
    }
    yaml_expect_list(yaml, after, SCENARIO_MAX_AWAITED);
    for (size_t i = 0; i < yaml_length(after) && !yaml->failed; i++) {
        start->awaited[start->awaited_count++] = scenario_event_index(yaml, yaml_item(yaml, after, i), self);
    }
}
