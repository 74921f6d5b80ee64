/* Reads the sections of a scenario file. Each section has its own function. All names are read first
 * (scenario_names.c), so that a section may refer to names in any other section, before or after it. */
#ifndef COMANIP_SIM_SCENARIO_SECTIONS_H
#define COMANIP_SIM_SCENARIO_SECTIONS_H

#include "scenario.h"
#include "yaml_choice.h"
#include "yaml_values.h"

/* Reads the names of objects, points, people and steps, and declares all events. */
void scenario_read_names(yaml_reader_t *yaml, scenario_t *self);

void scenario_read_robot(yaml_reader_t *yaml, scenario_t *self); /* arm, parameters, robot, water */
void scenario_read_tasks(yaml_reader_t *yaml, scenario_t *self);
void scenario_read_objects(yaml_reader_t *yaml, scenario_t *self);
void scenario_read_people(yaml_reader_t *yaml, scenario_t *self);
void scenario_read_operator(yaml_reader_t *yaml, scenario_t *self);
void scenario_read_checks(yaml_reader_t *yaml, scenario_t *self);

/* ---- common to sections */

void scenario_read_cup(yaml_reader_t *yaml, yaml_node_t *map, cup_t *cup);
void scenario_read_pose(yaml_reader_t *yaml, yaml_node_t *map, rigid_pose_t *pose); /* position_m, rotation */

/* Reads at_s, after, delay_s and patience_s. */
void scenario_read_start(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, step_start_t *start);

/* Resolve a name (scenario_references.c). Each returns the index, or 0 after an error. */
size_t scenario_object_index(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self);
size_t scenario_person_index(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self);
int scenario_event_index(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self);
point_t scenario_point(yaml_reader_t *yaml, const yaml_node_t *node, const scenario_t *self);

#define STEP_START_KEYS "at_s", "after", "delay_s", "patience_s"
#define FAR_M 10.0 /* limit of all coordinates */
#define LONG_S 3600.0

#endif
