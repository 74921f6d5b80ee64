#include "option_values.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NUMBER_BYTES 64

/* Digits as a person writes them: strtod() would also take blanks, "inf", "nan" and hexadecimal. */
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
