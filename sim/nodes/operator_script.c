#include "operator_script.h"

#include <stdio.h>

#define PARAMETERS_AT_S 0.01
#define READY_TIMEOUT_S 3.0

static size_t add_parameters(const scenario_t *scenario, const operator_overrides_t *overrides,
                             operator_step_t steps[]) {
    size_t count = 0;
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        if (scenario->parameter_written[i] || overrides->parameter_written[i]) {
            const bool is_overridden = overrides->parameter_written[i];
            steps[count++] = (operator_step_t){
                OPERATOR_WRITE_PARAMETER,
                .start.at_s = PARAMETERS_AT_S,
                .done_event = EVENT_NONE,
                .parameter = (uint8_t)i,
                .value = is_overridden ? overrides->parameter_value[i] : scenario->parameter_value[i],
            };
        }
    }
    return count;
}

static int done_event(const scenario_t *scenario, const operate_step_t *from) {
    char name[EVENT_NAME_BYTES];
    (void)snprintf(name, sizeof name, "operator.%s", from->name);
    return from->name[0] == '\0' ? EVENT_NONE : events_find(&scenario->events, name);
}

static void set_task(operator_step_t *step, const task_define_t *task) {
    step->action = OPERATOR_DEFINE_TASK;
    step->command = COMMAND_DEFINE;
    step->define = *task;
}

static operator_step_t convert(const scenario_t *scenario, const operate_step_t *from) {
    operator_step_t step = {.start = from->start, .done_event = done_event(scenario, from)};
    switch (from->kind) {
    case OPERATE_COMMAND:
        step.action = OPERATOR_COMMAND;
        step.command = from->command;
        step.task = from->task;
        step.in_cooperation = from->command == COMMAND_LATCH || from->command == COMMAND_CLUTCH;
        break;
    case OPERATE_DEFINE: set_task(&step, &scenario->own_task[from->own_task].define); break;
    case OPERATE_GRIPPER:
        step.action = OPERATOR_MOVE_GRIPPER;
        step.close = from->close;
        break;
    }
    return step;
}

static bool chooses_task(const operate_step_t *step) {
    return step->kind == OPERATE_DEFINE || (step->kind == OPERATE_COMMAND && step->command == COMMAND_SELECT);
}

static bool starts(const operate_step_t *step) {
    return step->kind == OPERATE_COMMAND && step->command == COMMAND_START;
}

size_t operator_script(const scenario_t *scenario, const operator_overrides_t *overrides, operator_step_t steps[]) {
    size_t count = add_parameters(scenario, overrides, steps);
    steps[count++] = (operator_step_t){OPERATOR_AWAIT_MODE, .done_event = EVENT_NONE, .mode = MODE_READY,
                                       .mode_timeout_s = READY_TIMEOUT_S};
    bool define_is_due = overrides->defines_task;
    bool clutch_is_due = overrides->clutch_s > 0.0;
    for (size_t i = 0; i < scenario->operate_count; i++) {
        const operate_step_t *from = &scenario->operate[i];
        if (define_is_due && starts(from)) { /* no step before the start command selects a task */
            steps[count] = (operator_step_t){.done_event = EVENT_NONE};
            set_task(&steps[count++], &overrides->task);
            define_is_due = false;
        }
        steps[count] = convert(scenario, from);
        if (define_is_due && chooses_task(from)) {
            set_task(&steps[count], &overrides->task);
            define_is_due = false;
        }
        count++;
        if (clutch_is_due && starts(from)) { /* steps of the script that are due before clutch_s are executed first */
            steps[count++] =
                (operator_step_t){OPERATOR_COMMAND,  .start.at_s = overrides->clutch_s, .in_cooperation = true,
                                  .gives_way = true, .done_event = EVENT_NONE,          .command = COMMAND_CLUTCH};
            clutch_is_due = false;
        }
    }
    return count;
}
