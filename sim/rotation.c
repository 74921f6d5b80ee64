#include "rotation.h"

#include <math.h>

void rotation_multiply(const double a[4], const double b[4], double product[4]) {
    const double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    const double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    const double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    const double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
    product[0] = w;
    product[1] = x;
    product[2] = y;
    product[3] = z;
}

void rotation_apply(const double rotation[4], const double v[3], double rotated[3]) {
    const double pure[4] = {0.0, v[0], v[1], v[2]};
    const double inverse[4] = {rotation[0], -rotation[1], -rotation[2], -rotation[3]};
    double half[4], whole[4];
    rotation_multiply(rotation, pure, half);
    rotation_multiply(half, inverse, whole);
    rotated[0] = whole[1];
    rotated[1] = whole[2];
    rotated[2] = whole[3];
}

double rotation_angle_between(const double a[4], const double b[4]) {
    const double inverse[4] = {a[0], -a[1], -a[2], -a[3]};
    double difference[4];
    rotation_multiply(inverse, b, difference);
    const double sine = sqrt(difference[1] * difference[1] + difference[2] * difference[2] +
                             difference[3] * difference[3]);
    return 2.0 * atan2(sine, fabs(difference[0])); /* atan2, not acos: exact for small angles */
}
