#include "text_number.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define WRITTEN_MAX 1e9 /* even multiplied by 1e9 (nine decimals), this value fits in 64 bits */

char *text_number_write(char *out, double value, int decimals) {
    static const double power[] = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    if (!(fabs(value) < WRITTEN_MAX)) {
        memcpy(out, "nan", 3);
        return out + 3;
    }
    const int64_t scaled = (int64_t)nearbyint(value * power[decimals]);
    uint64_t rest = scaled < 0 ? (uint64_t)-scaled : (uint64_t)scaled;
    char digit[24];
    int count = 0;
    while (rest > 0 || count <= decimals) { /* at least one digit before the point */
        digit[count++] = (char)('0' + rest % 10);
        rest /= 10;
    }
    if (scaled < 0) {
        *out++ = '-';
    }
    while (count > 0) {
        if (count == decimals) {
            *out++ = '.';
        }
        *out++ = digit[--count];
    }
    return out;
}
