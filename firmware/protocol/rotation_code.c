/* Encodes and decodes rotations: see rotation_code.h. */
#include "rotation_code.h"

#define ONE ((int64_t)1 << ROTATION_CODE_ONE_BITS)
#define UNIT (ONE * ONE)
#define TOLERANCE (UNIT / 512) /* tolerance of the squared norm, that is, 1e-3 for the norm */
#define ENCODE 5931280         /* 16383 sqrt(2) 2^8 */
#define DECODE 2966002         /* 2^22 / (16383 sqrt(2)) 2^14 */

static int64_t divide_rounding(int64_t value, int64_t divisor) {
    return (value + (value < 0 ? -divisor : divisor) / 2) / divisor;
}

static int64_t size_of(int64_t value) {
    return value < 0 ? -value : value;
}

bool rotation_encode(const int32_t quaternion[4], rotation_code_t *code) {
    int64_t norm = 0;
    *code = (rotation_code_t){0};
    for (uint8_t i = 0; i < 4; i++) {
        norm += (int64_t)quaternion[i] * quaternion[i];
        code->largest = size_of(quaternion[i]) > size_of(quaternion[code->largest]) ? i : code->largest;
    }
    if (size_of(norm - UNIT) > TOLERANCE) {
        return false;
    }
    const int64_t sign = quaternion[code->largest] < 0 ? -1 : 1;
    for (int i = 0, place = 0; i < 4; i++) {
        if (i != code->largest) {
            int64_t c = divide_rounding(sign * quaternion[i] * ENCODE, ONE << 8);
            /* Rounding may exceed the range if two components are equally large and the norm is slightly above 1. */
            c = c > ROTATION_CODE_MAX ? ROTATION_CODE_MAX : c;
            code->smaller[place++] = (int16_t)(c < -ROTATION_CODE_MAX ? -ROTATION_CODE_MAX : c);
        }
    }
    return true;
}

/* Returns the integer square root, rounded down, computed bit by bit. */
static int32_t square_root(int64_t square) {
    int32_t root = 0;
    for (int32_t bit = (int32_t)ONE; bit != 0; bit >>= 1) {
        int64_t candidate = root | bit;
        root = candidate * candidate <= square ? (int32_t)candidate : root;
    }
    return root;
}

void rotation_decode(const rotation_code_t *code, int32_t quaternion[4]) {
    int64_t rest = UNIT;
    for (int i = 0, place = 0; i < 4; i++) {
        if (i != code->largest) {
            quaternion[i] = (int32_t)divide_rounding((int64_t)code->smaller[place++] * DECODE, 1 << 14);
            rest -= (int64_t)quaternion[i] * quaternion[i];
        }
    }
    quaternion[code->largest] = square_root(rest < 0 ? 0 : rest);
}
