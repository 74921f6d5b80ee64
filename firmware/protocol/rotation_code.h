/* The smallest-three code of a rotation, in 47 bits: the three smaller components of its unit quaternion, from which
 * the largest follows. The code is computed in integer arithmetic, so all targets compute the same bits. */
#ifndef COMANIP_ROTATION_CODE_H
#define COMANIP_ROTATION_CODE_H

#include <stdbool.h>
#include <stdint.h>

#define ROTATION_CODE_ONE_BITS 22 /* fixed point: a quaternion component of 1 is 2^22 */
#define ROTATION_CODE_MAX 16383   /* code of 1/sqrt(2), the largest possible value of a smaller component */

typedef struct {
    int16_t smaller[3]; /* in the order w x y z */
    uint8_t largest;    /* index (w x y z) of the component of largest magnitude; if negative, all signs are changed */
} rotation_code_t;

/* Encodes a quaternion w x y z, in fixed point. Returns false if its norm is not 1 within 1e-3. */
bool rotation_encode(const int32_t quaternion[4], rotation_code_t *code);

/* Decodes a rotation. The result is within 0.009 deg of the encoded rotation. */
void rotation_decode(const rotation_code_t *code, int32_t quaternion[4]);

#endif
