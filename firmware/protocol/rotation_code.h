/* A rotation in 47 bits: the three smaller components of its unit quaternion, for the largest follows from them. In
 * integers, so that all targets compute the same bits. */
#ifndef COMANIP_ROTATION_CODE_H
#define COMANIP_ROTATION_CODE_H

#include <stdbool.h>
#include <stdint.h>

#define ROTATION_CODE_ONE_BITS 22 /* 1 is 2^22 in a quaternion w x y z */
#define ROTATION_CODE_MAX 16383   /* is 1/sqrt(2), beyond which no smaller component lies */

typedef struct {
    int16_t smaller[3]; /* in the order of w x y z */
    uint8_t largest;    /* 0..3: w x y z; it is not negative, for q and -q are one rotation */
} rotation_code_t;

/* False: the quaternion's norm is not 1 within 1e-3. */
bool rotation_encode(const int32_t quaternion[4], rotation_code_t *code);

/* Within 0.009 deg of what was encoded. */
void rotation_decode(const rotation_code_t *code, int32_t quaternion[4]);

#endif
