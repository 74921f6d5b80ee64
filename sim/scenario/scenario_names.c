/* First pass over a scenario file: who and what there is, and all that can happen. */
#include <stdio.h>
#include <string.h>

#include "scenario_sections.h"

static void declare(yaml_reader_t *yaml, scenario_t *self, const yaml_node_t *node, const char *actor,
                    const char *what) {
    if (events_declare(&self->events, actor, what) == EVENT_NONE) {
        yaml_refuse(yaml, node, "name", "fewer named steps, or shorter names");
    }
}

/* "done", "holds", ... are the scene's words. */
static void declare_steps(yaml_reader_t *yaml, scenario_t *self, yaml_node_t *steps, const char *actor) {
    for (size_t i = 0; i < yaml_length(steps); i++) {
        const yaml_node_t *name = yaml_find(yaml, yaml_item(yaml, steps, i), "name");
        scenario_name_t text = "";
        if (name == NULL) {
            continue;
        }
        yaml_copy_name(yaml, name, yaml_text(yaml, name, "name"), text, sizeof text);
        const bool taken = strcmp(text, "done") == 0 || strcmp(text, "holds") == 0 || strcmp(text, "lost") == 0;
        if (taken) {
            yaml_refuse(yaml, name, "name", "another name: done, holds and lost are events of their own");
        }
        declare(yaml, self, name, actor, text);
    }
}

static void read_points(yaml_reader_t *yaml, yaml_node_t *object, object_t *data) {
    yaml_node_t *points = yaml_find(yaml, object, "points");
    const char *name;
    yaml_node_t *name_node, *along;
    for (size_t i = 0; yaml_entry(yaml, points, i, &name, &name_node, &along); i++) {
        if (data->point_count == SCENARIO_MAX_POINTS) {
            yaml_refuse(yaml, name_node, "points", "at most 4 points");
            return;
        }
        object_point_t *point = &data->point[data->point_count++];
        yaml_copy_name(yaml, name_node, name, point->name, sizeof point->name);
        point->along_m = yaml_number(yaml, along, "along_m", -FAR_M, FAR_M);
    }
}

static void read_object_names(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *objects = yaml_find(yaml, yaml_root(yaml), "objects");
    const char *name;
    yaml_node_t *name_node, *object;
    for (size_t i = 0; yaml_entry(yaml, objects, i, &name, &name_node, &object); i++) {
        if (self->object_count == SCENARIO_MAX_OBJECTS) {
            yaml_refuse(yaml, name_node, "objects", "at most 8 objects");
            return;
        }
        object_t *data = &self->object[self->object_count++];
        yaml_copy_name(yaml, name_node, name, data->name, sizeof data->name);
        read_points(yaml, object, data);
        declare(yaml, self, name_node, data->name, "dropped");
    }
}

static void read_people_names(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *people = yaml_find(yaml, yaml_root(yaml), "people");
    const char *name;
    yaml_node_t *name_node, *person;
    for (size_t i = 0; yaml_entry(yaml, people, i, &name, &name_node, &person); i++) {
        if (self->person_count == SCENARIO_MAX_PEOPLE) {
            yaml_refuse(yaml, name_node, "people", "at most 2 people");
            return;
        }
        person_t *data = &self->person[self->person_count++];
        yaml_copy_name(yaml, name_node, name, data->name, sizeof data->name);
        if (strcmp(name, "robot") == 0 || strcmp(name, "operator") == 0) {
            yaml_refuse(yaml, name_node, "people", "another name: robot and operator are there already");
        }
        declare(yaml, self, name_node, data->name, "done");
        declare(yaml, self, name_node, data->name, "holds");
        declare(yaml, self, name_node, data->name, "lost");
        declare_steps(yaml, self, yaml_find(yaml, person, "program"), data->name);
        declare_steps(yaml, self, yaml_find(yaml, person, "program_with_recording"), data->name);
    }
}

void scenario_read_names(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const robot_events[] = {"holds", "lost", "opened", "closed"};
    for (size_t i = 0; i < sizeof robot_events / sizeof robot_events[0]; i++) {
        (void)events_declare(&self->events, "robot", robot_events[i]);
    }
    read_object_names(yaml, self);
    read_people_names(yaml, self);
    declare_steps(yaml, self, yaml_find(yaml, yaml_root(yaml), "operator"), "operator");
}

/* ---- references */

static size_t refuse_name(yaml_reader_t *yaml, const yaml_node_t *node, const char *key, const char *what,
                          const char *(*name_at)(const scenario_t *, size_t), const scenario_t *self, size_t count) {
    char expected[400];
    (void)snprintf(expected, sizeof expected, "the name of %s:", what);
    for (size_t i = 0; i < count; i++) {
        const size_t used = strlen(expected);
        (void)snprintf(expected + used, sizeof expected - used, "%s %s", i > 0 ? "," : "", name_at(self, i));
    }
    yaml_refuse(yaml, node, key, expected);
    return 0;
}

static const char *object_name(const scenario_t *self, size_t i) {
    return self->object[i].name;
}

static const char *person_name(const scenario_t *self, size_t i) {
    return self->person[i].name;
}

static const char *event_name(const scenario_t *self, size_t i) {
    return self->events.event[i].name;
}

size_t scenario_object_number(yaml_reader_t *yaml, const yaml_node_t *node, const char *key, const scenario_t *self) {
    const char *text = yaml_text(yaml, node, key);
    for (size_t i = 0; i < self->object_count; i++) {
        if (strcmp(text, self->object[i].name) == 0) {
            return i;
        }
    }
    return refuse_name(yaml, node, key, "an object", object_name, self, self->object_count);
}

size_t scenario_person_number(yaml_reader_t *yaml, const yaml_node_t *node, const char *key, const scenario_t *self) {
    const char *text = yaml_text(yaml, node, key);
    for (size_t i = 0; i < self->person_count; i++) {
        if (strcmp(text, self->person[i].name) == 0) {
            return i;
        }
    }
    return refuse_name(yaml, node, key, "a person", person_name, self, self->person_count);
}

int scenario_event_number(yaml_reader_t *yaml, const yaml_node_t *node, const char *key, const scenario_t *self) {
    const int event = events_find(&self->events, yaml_text(yaml, node, key));
    return event != EVENT_NONE
               ? event : (int)refuse_name(yaml, node, key, "an event", event_name, self, self->events.count);
}

point_t scenario_point(yaml_reader_t *yaml, const yaml_node_t *node, const char *key, const scenario_t *self) {
    const char *text = yaml_text(yaml, node, key);
    char name[2 * SCENARIO_NAME_BYTES];
    if (strcmp(text, "robot.gripper") == 0) {
        return (point_t){.kind = POINT_ROBOT_GRIPPER};
    }
    for (size_t i = 0; i < self->person_count; i++) {
        (void)snprintf(name, sizeof name, "%s.grip", self->person[i].name);
        if (strcmp(text, name) == 0) {
            return (point_t){.kind = POINT_PERSON_GRIP, .index = i};
        }
    }
    for (size_t i = 0; i < self->object_count; i++) {
        for (size_t j = 0; j < self->object[i].point_count; j++) {
            (void)snprintf(name, sizeof name, "%s.%s", self->object[i].name, self->object[i].point[j].name);
            if (strcmp(text, name) == 0) {
                return (point_t){.kind = POINT_OBJECT, .index = i, .point = j};
            }
        }
    }
    yaml_refuse(yaml, node, key, "a point: robot.gripper, PERSON.grip, or OBJECT.POINT of the object's points");
    return (point_t){.kind = POINT_NONE};
}

void scenario_read_start(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, step_start_t *start) {
    yaml_get_number(yaml, map, "at_s", 0.0, LONG_S, &start->at_s);
    yaml_get_number(yaml, map, "delay_s", 0.0, LONG_S, &start->delay_s);
    yaml_get_number(yaml, map, "patience_s", 0.0, LONG_S, &start->patience_s);
    yaml_node_t *after = yaml_find(yaml, map, "after");
    if (after == NULL) {
        return;
    }
    if (!yaml_is_sequence(after)) {
        start->awaited[start->awaited_count++] = scenario_event_number(yaml, after, "after", self);
        return;
    }
    for (size_t i = 0; i < yaml_length(after); i++) {
        if (start->awaited_count == SCENARIO_MAX_AWAITED) {
            yaml_refuse(yaml, after, "after", "at most 3 events");
            return;
        }
        start->awaited[start->awaited_count++] =
            scenario_event_number(yaml, yaml_item(yaml, after, i), "after", self);
    }
}
