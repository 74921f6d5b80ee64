#include "option_values.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NUMBER_BYTES 64
#define TASK_PARTS 5
#define TASK_BYTES 256
#define TASK_DISTANCE_MAX_M 8.388 /* largest distance that a signed 24-bit number of micrometres can hold */
#define TASK_BLEND_MAX_S 65.535
#define UNIT_TOLERANCE 1e-3 /* largest deviation of a quaternion's norm from 1 */

/* Returns true if the text has only characters of a decimal number. strtod() alone would also accept blanks, "inf",
 * "nan" and hexadecimal numbers. */
static bool is_decimal(const char *text) {
    return text[0] != '\0' && strspn(text, "+-.0123456789eE") == strlen(text);
}

bool option_number(const char *text, double minimum, double maximum, double *value) {
    char *end = NULL;
    if (!is_decimal(text)) {
        return false;
    }
    *value = strtod(text, &end);
    return *end == '\0' && isfinite(*value) && *value >= minimum && *value <= maximum;
}

bool option_unsigned(const char *text, uint64_t maximum, uint64_t *value) {
    if (text[0] == '\0' || strspn(text, "0123456789") != strlen(text)) {
        return false;
    }
    errno = 0;
    const unsigned long long number = strtoull(text, NULL, 10);
    *value = number;
    return errno == 0 && number <= maximum;
}

bool option_numbers(const char *text, char separator, double minimum, double maximum, size_t count, double value[]) {
    for (size_t i = 0; i < count; i++) {
        const bool is_last = i + 1 == count;
        const char *end = is_last ? text + strlen(text) : strchr(text, separator);
        char number[NUMBER_BYTES];
        if (end == NULL || (size_t)(end - text) >= sizeof number) {
            return false;
        }
        memcpy(number, text, (size_t)(end - text));
        number[end - text] = '\0';
        if (!option_number(number, minimum, maximum, &value[i])) {
            return false;
        }
        text = is_last ? end : end + 1;
    }
    return true;
}

static bool unit_quaternion(const char *text, quaternion_t *quaternion) {
    double q[4];
    if (!option_numbers(text, ',', -1.0 - UNIT_TOLERANCE, 1.0 + UNIT_TOLERANCE, 4, q)) {
        return false;
    }
    const double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    *quaternion =
        (quaternion_t){(float)(q[0] / norm), (float)(q[1] / norm), (float)(q[2] / norm), (float)(q[3] / norm)};
    return fabs(norm - 1.0) <= UNIT_TOLERANCE;
}

bool option_task(const char *text, task_define_t *task) {
    char copy[TASK_BYTES];
    char *part[TASK_PARTS] = {copy};
    if (strlen(text) >= sizeof copy) {
        return false;
    }
    memcpy(copy, text, strlen(text) + 1);
    for (size_t i = 1; i < TASK_PARTS; i++) {
        char *colon = strchr(part[i - 1], ':');
        if (colon == NULL) {
            return false;
        }
        *colon = '\0';
        part[i] = colon + 1;
    }
    double t_m[3], blend_s;
    const bool mirrored = strcmp(part[0], "mirrored") == 0;
    if (!(mirrored || strcmp(part[0], "constant") == 0) ||
        !option_numbers(part[1], ',', -TASK_DISTANCE_MAX_M, TASK_DISTANCE_MAX_M, 3, t_m) ||
        !option_number(part[4], 0.0, TASK_BLEND_MAX_S, &blend_s)) {
        return false;
    }
    task->form = mirrored ? TASK_FORM_MIRRORED : TASK_FORM_CONSTANT;
    task->t_task_m = (vector3_t){(float)t_m[0], (float)t_m[1], (float)t_m[2]};
    task->blend_s = (float)blend_s;
    return unit_quaternion(part[2], &task->q_task) && unit_quaternion(part[3], &task->q_inv);
}
