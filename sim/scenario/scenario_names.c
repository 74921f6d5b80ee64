/* Makes the first pass over a scenario file, which reads the names of objects and people, and declares all events. */
#include <string.h>

#include "scenario_sections.h"
#include "yaml_choice.h"

static void declare(yaml_reader_t *yaml, scenario_t *self, const yaml_node_t *node, const char *actor,
                    const char *what) {
    if (events_declare(&self->events, actor, what) == EVENT_NONE) {
        yaml_refuse(yaml, node, "fewer named steps: a scenario has at most %d events", EVENTS_MAX);
    }
}

/* ---- steps */

static yaml_node_t *step_name(yaml_reader_t *yaml, yaml_node_t *steps, size_t i) {
    return yaml_find(yaml, yaml_item(yaml, steps, i), "name");
}

/* Rejects the name of step i if an earlier step of the same list has this name. A step of program and a step of
 * program_with_recording may have the same name, because only one of the two lists is executed. */
static void refuse_repeated(yaml_reader_t *yaml, yaml_node_t *steps, size_t i) {
    const yaml_node_t *name = step_name(yaml, steps, i);
    for (size_t j = 0; j < i; j++) {
        const yaml_node_t *other = step_name(yaml, steps, j);
        if (other != NULL && strcmp(yaml_scalar(name), yaml_scalar(other)) == 0) {
            yaml_refuse(yaml, name, "another name: the step in line %zu already has this name",
                        other->start_mark.line + 1);
        }
    }
}

static void declare_steps(yaml_reader_t *yaml, scenario_t *self, yaml_node_t *steps, const char *actor) {
    static const char *const taken[] = {"done", "holds", "lost", NULL};
    yaml_expect_list(yaml, steps, SCENARIO_MAX_STEPS);
    for (size_t i = 0; i < yaml_length(steps) && !yaml->failed; i++) {
        const yaml_node_t *node = step_name(yaml, steps, i);
        scenario_name_t name = "";
        if (node == NULL) {
            continue;
        }
        yaml_name(yaml, node, name, sizeof name);
        if (yaml_choice(name, taken) >= 0) {
            yaml_refuse(yaml, node, "another name: done, holds and lost are reserved events");
        }
        refuse_repeated(yaml, steps, i);
        declare(yaml, self, node, actor, name);
    }
}

/* ---- objects and people */

static void read_points(yaml_reader_t *yaml, yaml_node_t *points, object_t *object) {
    yaml_node_t *name, *along;
    yaml_expect_mapping(yaml, points);
    for (size_t i = 0; yaml_entry(yaml, points, i, &name, &along); i++) {
        if (object->point_count == SCENARIO_MAX_POINTS) {
            yaml_refuse(yaml, points, "at most %d points", SCENARIO_MAX_POINTS);
            return;
        }
        object_point_t *point = &object->point[object->point_count++];
        yaml_name(yaml, name, point->name, sizeof point->name);
    }
}

static void refuse_actor(yaml_reader_t *yaml, const yaml_node_t *name) {
    static const char *const actors[] = {"robot", "operator", NULL};
    if (yaml_choice(yaml_scalar(name), actors) >= 0) {
        yaml_refuse(yaml, name, "another name: robot and operator are reserved");
    }
}

static void read_object_names(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *objects = yaml_find(yaml, yaml_root(yaml), "objects");
    yaml_node_t *name, *object;
    yaml_expect_mapping(yaml, objects);
    for (size_t i = 0; yaml_entry(yaml, objects, i, &name, &object) && !yaml->failed; i++) {
        if (self->object_count == SCENARIO_MAX_OBJECTS) {
            yaml_refuse(yaml, objects, "at most %d objects", SCENARIO_MAX_OBJECTS);
            return;
        }
        object_t *data = &self->object[self->object_count++];
        yaml_name(yaml, name, data->name, sizeof data->name);
        refuse_actor(yaml, name);
        read_points(yaml, yaml_find(yaml, object, "points"), data);
        declare(yaml, self, name, data->name, "dropped");
    }
}

/* Rejects a person with the name of an object, because "NAME.grip" and "NAME.dropped" would be ambiguous. */
static void refuse_object(yaml_reader_t *yaml, const yaml_node_t *name, const scenario_t *self) {
    for (size_t i = 0; i < self->object_count; i++) {
        if (strcmp(yaml_scalar(name), self->object[i].name) == 0) {
            yaml_refuse(yaml, name, "another name: an object already has this name");
        }
    }
}

static void read_people_names(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *people = yaml_find(yaml, yaml_root(yaml), "people");
    yaml_node_t *name, *person;
    yaml_expect_mapping(yaml, people);
    for (size_t i = 0; yaml_entry(yaml, people, i, &name, &person) && !yaml->failed; i++) {
        if (self->person_count == SCENARIO_MAX_PEOPLE) {
            yaml_refuse(yaml, people, "at most %d people", SCENARIO_MAX_PEOPLE);
            return;
        }
        person_t *data = &self->person[self->person_count++];
        yaml_name(yaml, name, data->name, sizeof data->name);
        refuse_actor(yaml, name);
        refuse_object(yaml, name, self);
        declare(yaml, self, name, data->name, "done");
        declare(yaml, self, name, data->name, "holds");
        declare(yaml, self, name, data->name, "lost");
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
