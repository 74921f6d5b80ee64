/* Section operator. */
#include <string.h>

#include "scenario_sections.h"

enum { DO_SELECT, DO_START, DO_LATCH, DO_CLUTCH, DO_STOP, DO_GRIPPER };

static void read_select(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, operate_step_t *step) {
    static const char *const built_in[] = {"pour", "teleop", "mirror", NULL}; /* in the order of task_id_t */
    const yaml_node_t *node = yaml_need(yaml, map, "select", "task");
    const char *name = yaml_text(yaml, node, "task");
    for (size_t i = 0; i < self->own_task_count; i++) {
        if (strcmp(name, self->own_task[i].name) == 0) {
            step->kind = OPERATE_DEFINE;
            step->command = COMMAND_DEFINE;
            step->own_task = i;
            return;
        }
    }
    const int task = yaml_word(yaml, node, "task (one of the file's own, or built in)", built_in);
    step->command = COMMAND_SELECT;
    step->task = task >= 0 ? (task_id_t)task : TASK_POUR;
}

static void read_step(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, operate_step_t *step) {
    static const char *const actions[] = {"select", "start", "latch", "clutch", "stop", "gripper", NULL};
    static const char *const keys[] = {"do", "name", STEP_START_KEYS, "task", "action", NULL};
    static const char *const moves[] = {"open", "close", NULL};
    static const command_t commands[] = {COMMAND_SELECT, COMMAND_START, COMMAND_LATCH, COMMAND_CLUTCH, COMMAND_STOP,
                                         COMMAND_NONE};
    const int action = yaml_word(yaml, yaml_need(yaml, map, "step", "do"), "do", actions);
    if (action < 0) {
        return;
    }
    yaml_check_keys(yaml, map, actions[action], keys);
    yaml_get_text(yaml, map, "name", step->name, sizeof step->name);
    scenario_read_start(yaml, map, self, &step->start);
    step->kind = OPERATE_COMMAND;
    step->command = commands[action];
    if (action == DO_SELECT) {
        read_select(yaml, map, self, step);
    } else if (action == DO_GRIPPER) {
        step->kind = OPERATE_GRIPPER;
        step->close = yaml_word(yaml, yaml_need(yaml, map, "gripper", "action"), "action", moves) == 1;
    }
}

void scenario_read_operator(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *list = yaml_need(yaml, yaml_root(yaml), "scenario", "operator");
    if (!yaml_is_sequence(list)) {
        yaml_refuse(yaml, list, "operator", "a list of steps");
    }
    for (size_t i = 0; i < yaml_length(list); i++) {
        if (self->operate_count == SCENARIO_MAX_STEPS) {
            yaml_refuse(yaml, list, "operator", "at most 40 steps");
            return;
        }
        read_step(yaml, yaml_item(yaml, list, i), self, &self->operate[self->operate_count++]);
    }
}
