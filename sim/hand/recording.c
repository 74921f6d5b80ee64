/* Reads a recorded motion. The file may contain anything, so every number is checked before it is used. */
#include "recording.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define LINE_BYTES 1024
#define MAX_COLUMNS 13
#define QUATERNION_COLUMNS 8

static const char byte_order_mark[] = "\xEF\xBB\xBF"; /* encoded in UTF-8 */
static const char quaternion_header[] = "t_s,x_m,y_m,z_m,qw,qx,qy,qz";
static const char matrix_header[] = "t_s,x_m,y_m,z_m,r11,r12,r13,r21,r22,r23,r31,r32,r33";

typedef struct {
    FILE *file;
    const char *path;
    size_t line;           /* number of the line in `text`; 0: errors concern the whole file */
    char text[LINE_BYTES]; /* without the newline */
    const char *header;
    int columns;
    char *error;
    size_t error_size;
} reader_t;

__attribute__((format(printf, 2, 3))) static bool fail(reader_t *self, const char *format, ...) {
    char message[256];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    for (char *character = message; *character != '\0'; character++) {
        if (iscntrl((unsigned char)*character)) {
            *character = '?'; /* bytes of the file must not act as terminal control codes */
        }
    }
    if (self->line == 0) {
        (void)snprintf(self->error, self->error_size, "%s: %s", self->path, message);
    } else {
        (void)snprintf(self->error, self->error_size, "%s:%zu: %s", self->path, self->line, message);
    }
    return false;
}

typedef enum { LINE_READ, LINE_END, LINE_FAILED } line_status_t;

static line_status_t read_line(reader_t *self) {
    self->line++;
    if (fgets(self->text, sizeof self->text, self->file) == NULL) {
        if (ferror(self->file)) {
            (void)fail(self, "cannot be read: %s", strerror(errno));
            return LINE_FAILED;
        }
        return LINE_END;
    }
    size_t length = strlen(self->text);
    if (!feof(self->file) && (length == 0 || self->text[length - 1] != '\n')) {
        (void)fail(self, "is longer than %d characters or holds a zero byte, expected a line of text", LINE_BYTES - 2);
        return LINE_FAILED;
    }
    while (length > 0 && isspace((unsigned char)self->text[length - 1])) {
        self->text[--length] = '\0';
    }
    return LINE_READ;
}

static bool read_header(reader_t *self) {
    const line_status_t status = read_line(self);
    if (status == LINE_FAILED) {
        return false;
    }
    if (status == LINE_END) {
        self->line = 0;
        return fail(self, "is empty, expected the header %s", quaternion_header);
    }
    const char *text = self->text;
    if (strncmp(text, byte_order_mark, strlen(byte_order_mark)) == 0) { /* spreadsheet programs write one */
        text += strlen(byte_order_mark);
    }
    if (strcmp(text, quaternion_header) == 0) {
        self->header = quaternion_header;
        self->columns = QUATERNION_COLUMNS;
    } else if (strcmp(text, matrix_header) == 0) {
        self->header = matrix_header;
        self->columns = MAX_COLUMNS;
    } else {
        return fail(self, "header is '%.60s', expected %s or %s", text, quaternion_header, matrix_header);
    }
    return true;
}

/* Reads the field at `text`, which ends at a comma or at the end of the line. */
static bool read_number(reader_t *self, const char *text, const char *name, double *value) {
    const int length = (int)strcspn(text, ",");
    const int name_length = (int)strcspn(name, ",");
    char *end = NULL;
    *value = strtod(text, &end);
    const char *rest = end + strspn(end, " \t");
    /* strtod() would also accept nan, inf and hexadecimal */
    if (end == text || rest != text + length || (int)strspn(text, "0123456789+-.eE \t") != length) {
        return fail(self, "%.*s is '%.*s', expected a number", name_length, name, length > 40 ? 40 : length, text);
    }
    if (!isfinite(*value)) {
        return fail(self, "%.*s is %.*s, expected a finite number", name_length, name, length > 40 ? 40 : length, text);
    }
    return true;
}

static bool read_row(reader_t *self, double value[MAX_COLUMNS]) {
    int columns = 1;
    for (const char *character = self->text; *character != '\0'; character++) {
        columns += *character == ',';
    }
    if (columns != self->columns) {
        return fail(self, "has %d column%s, expected %d: %s", columns, columns == 1 ? "" : "s", self->columns,
                    self->header);
    }
    const char *text = self->text;
    const char *name = self->header;
    for (int i = 0; i < columns; i++) {
        if (!read_number(self, text, name, &value[i])) {
            return false;
        }
        text += strcspn(text, ",") + 1;
        name += strcspn(name, ",") + 1;
    }
    return true;
}

static bool convert_quaternion(reader_t *self, const double value[4], double rotation[4]) {
    memcpy(rotation, value, 4 * sizeof value[0]);
    const double norm = sqrt(rotation_dot(rotation, rotation));
    if (!(fabs(norm - 1.0) <= RECORDING_TOLERANCE)) {
        return fail(self, "norm of qw,qx,qy,qz is %.6g, expected 1 within %g", norm, RECORDING_TOLERANCE);
    }
    rotation_normalise(rotation);
    return true;
}

static bool convert_matrix(reader_t *self, const double value[9], double rotation[4]) {
    double matrix[3][3];
    memcpy(matrix, value, sizeof matrix);
    for (int i = 0; i < 3; i++) {
        for (int j = i; j < 3; j++) {
            const double product =
                matrix[0][i] * matrix[0][j] + matrix[1][i] * matrix[1][j] + matrix[2][i] * matrix[2][j];
            const double expected = i == j ? 1.0 : 0.0;
            if (!(fabs(product - expected) <= RECORDING_TOLERANCE)) {
                return fail(self,
                            "r11..r33 is not a rotation: the product of columns %d and %d is %.6g, "
                            "expected %g within %g",
                            i + 1, j + 1, product, expected, RECORDING_TOLERANCE);
            }
        }
    }
    const double determinant = matrix[0][0] * (matrix[1][1] * matrix[2][2] - matrix[1][2] * matrix[2][1]) -
                               matrix[0][1] * (matrix[1][0] * matrix[2][2] - matrix[1][2] * matrix[2][0]) +
                               matrix[0][2] * (matrix[1][0] * matrix[2][1] - matrix[1][1] * matrix[2][0]);
    if (determinant < 0.0) {
        return fail(self, "r11..r33 is a reflection: determinant %.6g, expected 1", determinant);
    }
    rotation_from_matrix((const double (*)[3])matrix, rotation);
    return true;
}

/* Converts a row to a sample. before: the previous sample; NULL for the first one. before_time_s: time of the previous
 * sample as written in the file. */
static bool convert_row(reader_t *self, const double value[], double first_time_s, const recording_sample_t *before,
                        double before_time_s, recording_sample_t *sample) {
    if (before != NULL && !(value[0] > before_time_s)) {
        return fail(self, "t_s is %.15g, expected more than the %.15g before it", value[0], before_time_s);
    }
    sample->time_s = value[0] - first_time_s;
    if (!(sample->time_s <= RECORDING_MAX_DURATION_S)) {
        return fail(self, "t_s is %.15g, expected at most %g s after the first sample", value[0],
                    RECORDING_MAX_DURATION_S);
    }
    for (int i = 0; i < 3; i++) {
        if (!(fabs(value[1 + i]) <= RECORDING_MAX_DISTANCE_M)) {
            return fail(self, "%c_m is %.15g, expected within %g m", "xyz"[i], value[1 + i], RECORDING_MAX_DISTANCE_M);
        }
        sample->pose.position_m[i] = value[1 + i];
    }
    double *rotation = sample->pose.rotation;
    if (!(self->columns == QUATERNION_COLUMNS ? convert_quaternion(self, &value[4], rotation)
                                              : convert_matrix(self, &value[4], rotation))) {
        return false;
    }
    if (before != NULL) {
        rigid_pose_choose_side(&sample->pose, &before->pose);
    }
    return true;
}

static bool read_samples(reader_t *self, recording_t *recording) {
    double value[MAX_COLUMNS];
    double first_time_s = 0.0;
    double before_time_s = 0.0;
    size_t capacity = 0;
    size_t blank_line = 0; /* number of the first blank line; 0: none. Blank lines are allowed only at the end */
    line_status_t status;
    while ((status = read_line(self)) == LINE_READ) {
        if (self->text[0] == '\0') {
            blank_line = blank_line == 0 ? self->line : blank_line;
            continue;
        }
        if (blank_line != 0) {
            self->line = blank_line;
            return fail(self, "is empty but followed by samples, expected %s", self->header);
        }
        if (recording->count == RECORDING_MAX_SAMPLES) {
            return fail(self, "is one sample too many, expected at most %d", RECORDING_MAX_SAMPLES);
        }
        if (recording->count == capacity) {
            capacity = capacity == 0 ? 4096 : 2 * capacity;
            recording_sample_t *grown = realloc(recording->sample, capacity * sizeof *grown);
            if (grown == NULL) {
                return fail(self, "not enough memory for %zu samples", capacity);
            }
            recording->sample = grown;
        }
        const recording_sample_t *before = recording->count == 0 ? NULL : &recording->sample[recording->count - 1];
        if (!read_row(self, value)) {
            return false;
        }
        first_time_s = before == NULL ? value[0] : first_time_s;
        if (!convert_row(self, value, first_time_s, before, before_time_s, &recording->sample[recording->count])) {
            return false;
        }
        before_time_s = value[0];
        recording->count++;
    }
    if (status == LINE_FAILED) {
        return false;
    }
    self->line = 0;
    if (recording->count < 2) {
        return fail(self, "samples: %zu, expected at least 2", recording->count);
    }
    return true;
}

static int compare_doubles(const void *a, const void *b) {
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

static bool find_median_interval(reader_t *reader, recording_t *self) {
    const size_t count = self->count - 1;
    double *interval_s = malloc(count * sizeof *interval_s);
    if (interval_s == NULL) {
        return fail(reader, "not enough memory for %zu samples", self->count);
    }
    for (size_t i = 0; i < count; i++) {
        interval_s[i] = self->sample[i + 1].time_s - self->sample[i].time_s;
    }
    qsort(interval_s, count, sizeof *interval_s, compare_doubles);
    self->median_interval_s = 0.5 * (interval_s[(count - 1) / 2] + interval_s[count / 2]);
    free(interval_s);
    return true;
}

bool recording_read(recording_t *self, const char *path, char error[], size_t error_size) {
    *self = (recording_t){.sample = NULL};
    reader_t reader = {.path = path, .error = error, .error_size = error_size};
    struct stat status;
    if (stat(path, &status) != 0) {
        return fail(&reader, "cannot be read: %s", strerror(errno));
    }
    if (!S_ISREG(status.st_mode)) { /* opening a pipe or a device could block for ever */
        const char *kind = S_ISDIR(status.st_mode) ? "a directory" : "not a regular file";
        return fail(&reader, "is %s, expected a CSV file", kind);
    }
    reader.file = fopen(path, "r");
    if (reader.file == NULL) {
        return fail(&reader, "cannot be read: %s", strerror(errno));
    }
    const bool complete = read_header(&reader) && read_samples(&reader, self) && find_median_interval(&reader, self);
    (void)fclose(reader.file);
    if (!complete) {
        recording_free(self);
    }
    return complete;
}

void recording_free(recording_t *self) {
    free(self->sample);
    *self = (recording_t){.sample = NULL};
}
