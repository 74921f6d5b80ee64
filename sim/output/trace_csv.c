#include "trace_csv.h"

#include <errno.h>
#include <string.h>

#include "../common/names.h"
#include "text_number.h"

#define LINE_BYTES 1024
#define POSITION_DECIMALS 7
#define ROTATION_DECIMALS 7

bool trace_csv_open(trace_csv_t *self, const char *path, char error[], size_t error_size) {
    self->file = fopen(path, "w");
    if (self->file == NULL) {
        (void)snprintf(error, error_size, "%s: cannot be written: %s", path, strerror(errno));
        return false;
    }
    (void)fputs("t_s,mode,target_x_m,target_y_m,target_z_m,target_qw,target_qx,target_qy,target_qz,"
                "hand_x_m,hand_y_m,hand_z_m,hand_qw,hand_qx,hand_qy,hand_qz",
                self->file);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        (void)fprintf(self->file, ",q%d_rad", i);
    }
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        (void)fprintf(self->file, ",dq%d_command_radps", i);
    }
    (void)fputc('\n', self->file);
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

void trace_csv_write(trace_csv_t *self, const tick_record_t *tick) {
    char line[LINE_BYTES];
    char *out = text_number_write(line, (double)tick->time_ns * 1e-9, 3);
    const char *mode = mode_name((uint8_t)tick->mode);
    const size_t mode_bytes = strlen(mode);
    *out++ = ',';
    memcpy(out, mode, mode_bytes);
    out += mode_bytes;
    out = tick->has_target ? write_pose(out, &tick->target) : write_empty(out, 7);
    out = write_pose(out, &tick->hand);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        out = write_cell(out, tick->measured_rad[i], 6);
    }
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        out = tick->has_command ? write_cell(out, (double)tick->command.velocity_radps[i], 3) : write_empty(out, 1);
    }
    *out++ = '\n';
    (void)fwrite(line, 1, (size_t)(out - line), self->file); /* an error stays with the file for trace_csv_close() */
}

bool trace_csv_close(trace_csv_t *self, const char *path, char error[], size_t error_size) {
    const bool failed = ferror(self->file) != 0;
    if (fclose(self->file) != 0 || failed) {
        (void)snprintf(error, error_size, "%s: not written completely: %s", path, strerror(errno));
        return false;
    }
    return true;
}
