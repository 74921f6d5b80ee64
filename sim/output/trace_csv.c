#include "trace_csv.h"

#include <errno.h>
#include <string.h>

#include "../common/names.h"
#include "text_number.h"

#define LINE_BYTES 2048 /* more than enough for 64 cells of at most 20 characters */
#define POSITION_DECIMALS 7
#define ROTATION_DECIMALS 7
#define POSE_CELLS 7
#define MM_PER_M 1e3

static void write_pose_names(FILE *file, const char *what) {
    (void)fprintf(file, ",%s_x_m,%s_y_m,%s_z_m,%s_qw,%s_qx,%s_qy,%s_qz", what, what, what, what, what, what, what);
}

static void write_names(FILE *file) {
    (void)fputs("t_s,mode", file);
    write_pose_names(file, "target");
    write_pose_names(file, "hand");
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        (void)fprintf(file, ",q%d_rad", i);
    }
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        (void)fprintf(file, ",dq%d_command_radps", i);
    }
    write_pose_names(file, "person");
    write_pose_names(file, "second");
    write_pose_names(file, "object");
    (void)fputs(",gripper_opening,force_x_N,force_y_N,force_z_N,second_force_N,clearance_person_mm,clearance_self_mm,"
                "water_robot,water_person,water_spilt,crank_turns\n",
                file);
}

bool trace_csv_open(trace_csv_t *self, const char *path, char error[], size_t error_size) {
    self->file = fopen(path, "w");
    if (self->file == NULL) {
        (void)snprintf(error, error_size, "%s: cannot be written: %s", path, strerror(errno));
        return false;
    }
    write_names(self->file);
    return true;
}

static char *write_cell(char *out, double value, int decimals) {
    *out++ = ',';
    return text_number_write(out, value, decimals);
}

static char *write_pose(char *out, const rigid_pose_t *pose) {
    for (int k = 0; k < 3; k++) {
        out = write_cell(out, pose->position_m[k], POSITION_DECIMALS);
    }
    for (int k = 0; k < 4; k++) {
        out = write_cell(out, pose->rotation[k], ROTATION_DECIMALS);
    }
    return out;
}

static char *write_empty(char *out, int cells) {
    memset(out, ',', (size_t)cells);
    return out + cells;
}

static char *write_robot(char *out, const tick_record_t *tick) {
    const char *mode = mode_name((uint8_t)tick->mode);
    const size_t mode_bytes = strlen(mode);
    out = text_number_write(out, (double)tick->time_ns * 1e-9, 3);
    *out++ = ',';
    memcpy(out, mode, mode_bytes);
    out += mode_bytes;
    out = tick->has_target ? write_pose(out, &tick->target) : write_empty(out, POSE_CELLS);
    out = write_pose(out, &tick->hand);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        out = write_cell(out, tick->measured_rad[i], 6);
    }
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        out = tick->has_command ? write_cell(out, (double)tick->command.velocity_radps[i], 3) : write_empty(out, 1);
    }
    return out;
}

static char *write_poses(char *out, const physical_state_t *state) {
    out = write_pose(out, &state->hand[state->tracked]);
    out = state->second >= 0 ? write_pose(out, &state->hand[state->second]) : write_empty(out, POSE_CELLS);
    return state->traced_object >= 0 ? write_pose(out, &state->object[state->traced_object])
                                     : write_empty(out, POSE_CELLS);
}

static char *write_contacts(char *out, const physical_state_t *state) {
    out = write_cell(out, state->gripper_opening, 4);
    if (physical_state_holds_any(state, state->tracked)) {
        for (int k = 0; k < 3; k++) {
            out = write_cell(out, state->hand_force_N[state->tracked][k], 4);
        }
    } else {
        out = write_empty(out, 3);
    }
    if (state->second >= 0 && physical_state_holds_any(state, (size_t)state->second)) {
        out = write_cell(out, physical_state_force_N(state, (size_t)state->second), 4);
    } else {
        out = write_empty(out, 1);
    }
    out = write_cell(out, MM_PER_M * state->clearance.person_m, 2);
    return write_cell(out, MM_PER_M * state->clearance.self_m, 2);
}

static char *write_water_and_crank(char *out, const physical_state_t *state) {
    if (state->has_water) {
        out = write_cell(out, state->water.in_robot_cup, 0);
        out = write_cell(out, state->water.in_person_cup, 0);
        out = write_cell(out, state->water.elsewhere, 0);
    } else {
        out = write_empty(out, 3);
    }
    return state->crank >= 0 ? write_cell(out, state->crank_turns[state->crank], 5) : write_empty(out, 1);
}

void trace_csv_write(trace_csv_t *self, const tick_record_t *tick, const physical_state_t *state) {
    char line[LINE_BYTES];
    char *out = write_robot(line, tick);
    out = write_poses(out, state);
    out = write_contacts(out, state);
    out = write_water_and_crank(out, state);
    *out++ = '\n';
    (void)fwrite(line, 1, (size_t)(out - line), self->file); /* trace_csv_close() reports errors */
}

bool trace_csv_close(trace_csv_t *self, const char *path, char error[], size_t error_size) {
    const bool failed = ferror(self->file) != 0;
    if (fclose(self->file) != 0 || failed) {
        (void)snprintf(error, error_size, "%s: not written completely: %s", path, strerror(errno));
        return false;
    }
    return true;
}
