/* Reads the section `operator` of a scenario file. */
#include "scenario_sections.h"
#include "yaml_choice.h"

/* The order must match actions[]. */
enum { DO_SELECT, DO_START, DO_LATCH, DO_CLUTCH, DO_STOP, DO_GRIPPER };

static const char *const actions[] = {"select", "start", "latch", "clutch", "stop", "gripper", NULL};

#define STEP_KEYS "do", "name", STEP_START_KEYS

#define NAME(NAME, number, name, form, t_task, q_task, q_inv) name,
#define NUMBER(NAME, number, name, form, t_task, q_task, q_inv) number,

/* Reads the name of a built-in task or of a task that the file defines. */
static void read_select(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, operate_step_t *step) {
    static const uint8_t numbers[] = {COMANIP_TASKS(NUMBER)};
    const char *tasks[COMANIP_TASK_COUNT + SCENARIO_MAX_TASKS + 1] = {COMANIP_TASKS(NAME)};
    for (size_t i = 0; i < self->own_task_count; i++) {
        tasks[COMANIP_TASK_COUNT + i] = self->own_task[i].name;
    }
    const yaml_node_t *node = yaml_need(yaml, map, "task");
    const int task = yaml_choice(yaml_scalar(node), tasks);
    if (task >= COMANIP_TASK_COUNT) {
        step->kind = OPERATE_DEFINE;
        step->command = COMMAND_DEFINE;
        step->own_task = (size_t)task - COMANIP_TASK_COUNT;
    } else if (task >= 0) {
        step->task = (task_id_t)numbers[task];
    } else if (node != NULL) {
        yaml_refuse_choice(yaml, node, "tasks", tasks);
    }
}

static void read_gripper(yaml_reader_t *yaml, yaml_node_t *map, operate_step_t *step) {
    static const char *const moves[] = {"open", "close", NULL};
    step->kind = OPERATE_GRIPPER;
    step->close = yaml_word(yaml, yaml_need(yaml, map, "action"), moves) == 1;
}

static void read_step(yaml_reader_t *yaml, yaml_node_t *map, const scenario_t *self, operate_step_t *step) {
    static const char *const keys[] = {STEP_KEYS, NULL}, *const select_keys[] = {STEP_KEYS, "task", NULL},
                             *const gripper_keys[] = {STEP_KEYS, "action", NULL};
    static const command_t commands[] = {COMMAND_SELECT, COMMAND_START, COMMAND_LATCH,
                                         COMMAND_CLUTCH, COMMAND_STOP,  COMMAND_NONE};
    const int action = yaml_word(yaml, yaml_need(yaml, map, "do"), actions);
    if (action < 0) {
        return;
    }
    yaml_check_keys(yaml, map, action == DO_SELECT ? select_keys : action == DO_GRIPPER ? gripper_keys : keys);
    yaml_get_name(yaml, map, "name", step->name, sizeof step->name);
    scenario_read_start(yaml, map, self, &step->start);
    step->kind = OPERATE_COMMAND;
    step->command = commands[action];
    if (action == DO_SELECT) {
        read_select(yaml, map, self, step);
    } else if (action == DO_GRIPPER) {
        read_gripper(yaml, map, step);
    }
}

void scenario_read_operator(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *list = yaml_need(yaml, yaml_root(yaml), "operator");
    bool starts = false;
    for (size_t i = 0; i < yaml_length(list) && !yaml->failed; i++) {
        operate_step_t *step = &self->operate[self->operate_count++];
        read_step(yaml, yaml_item(yaml, list, i), self, step);
        starts = starts || step->command == COMMAND_START;
    }
    if (!starts && !yaml->failed) {
        yaml_refuse(yaml, list, "a step with do: start");
    }
}
