/* Reads the section `tasks` of a scenario file. */
#include "scenario_sections.h"
#include "yaml_choice.h"

#define DISTANCE_MAX_M 8.0 /* within the range of the TaskDefine frame */
#define BLEND_MAX_S 65.0

static void read_task(yaml_reader_t *yaml, yaml_node_t *map, task_define_t *define) {
    static const char *const keys[] = {"form", "t_task_m", "q_task", "q_inv", "blend_s", NULL};
    static const char *const forms[] = {"constant", "mirrored", NULL};
    double t_task_m[3] = {0.0, 0.0, 0.0}, blend_s = 1.0;
    double q_task[4] = {1.0, 0.0, 0.0, 0.0}, q_inv[4] = {1.0, 0.0, 0.0, 0.0};
    yaml_check_keys(yaml, map, keys);
    const int form = yaml_word(yaml, yaml_need(yaml, map, "form"), forms);
    yaml_get_vector(yaml, map, "t_task_m", 3, -DISTANCE_MAX_M, DISTANCE_MAX_M, t_task_m);
    yaml_get_rotation(yaml, map, "q_task", q_task);
    yaml_get_rotation(yaml, map, "q_inv", q_inv);
    yaml_get_number(yaml, map, "blend_s", 0.0, BLEND_MAX_S, &blend_s);
    define->form = (uint8_t)(form == 1 ? TASK_FORM_MIRRORED : TASK_FORM_CONSTANT);
    define->t_task_m = (vector3_t){(float)t_task_m[0], (float)t_task_m[1], (float)t_task_m[2]};
    define->q_task = (quaternion_t){(float)q_task[0], (float)q_task[1], (float)q_task[2], (float)q_task[3]};
    define->q_inv = (quaternion_t){(float)q_inv[0], (float)q_inv[1], (float)q_inv[2], (float)q_inv[3]};
    define->blend_s = (float)blend_s;
}

void scenario_read_tasks(yaml_reader_t *yaml, scenario_t *self) {
#define NAME(NAME, number, name, form, t_task, q_task, q_inv) name,
    static const char *const built_in[] = {COMANIP_TASKS(NAME) NULL};
    yaml_node_t *tasks = yaml_find(yaml, yaml_root(yaml), "tasks");
    yaml_node_t *name, *task;
    yaml_expect_mapping(yaml, tasks);
    for (size_t i = 0; yaml_entry(yaml, tasks, i, &name, &task) && !yaml->failed; i++) {
        if (self->own_task_count == SCENARIO_MAX_TASKS) {
            yaml_refuse(yaml, tasks, "at most %d tasks", SCENARIO_MAX_TASKS);
            return;
        }
        own_task_t *own = &self->own_task[self->own_task_count++];
        yaml_name(yaml, name, own->name, sizeof own->name);
        if (yaml_choice(own->name, built_in) >= 0) {
            yaml_refuse(yaml, name, "another name: pour, teleop and mirror are built in");
        }
        read_task(yaml, task, &own->define);
    }
}
