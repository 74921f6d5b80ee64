#include "rigid_pose.h"

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
    const double sine =
        sqrt(difference[1] * difference[1] + difference[2] * difference[2] + difference[3] * difference[3]);
    return 2.0 * atan2(sine, fabs(difference[0])); /* unlike acos, atan2 is accurate for small angles */
}

double rotation_dot(const double a[4], const double b[4]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

void rotation_normalise(double rotation[4]) {
    const double norm = sqrt(rotation_dot(rotation, rotation));
    for (int i = 0; i < 4 && norm > 0.0; i++) {
        rotation[i] /= norm;
    }
}

void rotation_from_vector(const double v_rad[3], double rotation[4]) {
    const double angle = sqrt(v_rad[0] * v_rad[0] + v_rad[1] * v_rad[1] + v_rad[2] * v_rad[2]);
    const double factor = angle > 0.0 ? sin(0.5 * angle) / angle : 0.5;
    rotation[0] = cos(0.5 * angle);
    for (int i = 0; i < 3; i++) {
        rotation[i + 1] = factor * v_rad[i];
    }
}

/* Shepperd's method: computes the largest component first, which avoids cancellation, then the others from it. */
void rotation_from_matrix(const double matrix[3][3], double rotation[4]) {
    const double trace = matrix[0][0] + matrix[1][1] + matrix[2][2];
    int largest = 0;
    double largest_value = trace; /* trace = 4 w^2 - 1, and 2 r_ii - trace = 4 q_i^2 - 1 for q_1, q_2, q_3 = x, y, z */
    for (int i = 0; i < 3; i++) {
        const double value = 2.0 * matrix[i][i] - trace;
        if (value > largest_value) {
            largest = i + 1;
            largest_value = value;
        }
    }
    const double twice = sqrt(1.0 + largest_value); /* 2 |component| */
    if (largest == 0) {
        rotation[0] = 0.5 * twice;
        rotation[1] = 0.5 * (matrix[2][1] - matrix[1][2]) / twice;
        rotation[2] = 0.5 * (matrix[0][2] - matrix[2][0]) / twice;
        rotation[3] = 0.5 * (matrix[1][0] - matrix[0][1]) / twice;
    } else {
        const int i = largest - 1;
        const int j = (i + 1) % 3;
        const int k = (i + 2) % 3;
        rotation[0] = 0.5 * (matrix[k][j] - matrix[j][k]) / twice;
        rotation[i + 1] = 0.5 * twice;
        rotation[j + 1] = 0.5 * (matrix[j][i] + matrix[i][j]) / twice;
        rotation[k + 1] = 0.5 * (matrix[k][i] + matrix[i][k]) / twice;
    }
    rotation_normalise(rotation);
}

void rotation_interpolate(const double a[4], const double b[4], double fraction, double rotation[4]) {
    const double cosine = fmin(rotation_dot(a, b), 1.0);
    const double angle = acos(cosine);
    double weight_a = 1.0 - fraction;
    double weight_b = fraction;
    if (angle > 1e-6) { /* below this angle, the error of linear interpolation is less than 1e-13 */
        weight_a = sin(weight_a * angle) / sin(angle);
        weight_b = sin(weight_b * angle) / sin(angle);
    }
    for (int i = 0; i < 4; i++) {
        rotation[i] = weight_a * a[i] + weight_b * b[i];
    }
    rotation_normalise(rotation);
}

rigid_pose_t rigid_pose_multiply(const rigid_pose_t *a_to_b, const rigid_pose_t *b_to_c) {
    rigid_pose_t product;
    rotation_multiply(a_to_b->rotation, b_to_c->rotation, product.rotation);
    rotation_apply(a_to_b->rotation, b_to_c->position_m, product.position_m);
    for (int i = 0; i < 3; i++) {
        product.position_m[i] += a_to_b->position_m[i];
    }
    return product;
}

rigid_pose_t rigid_pose_inverse(const rigid_pose_t *pose) {
    const double *rotation = pose->rotation;
    rigid_pose_t inverse = {.rotation = {rotation[0], -rotation[1], -rotation[2], -rotation[3]}};
    rotation_apply(inverse.rotation, pose->position_m, inverse.position_m);
    for (int i = 0; i < 3; i++) {
        inverse.position_m[i] = -inverse.position_m[i];
    }
    return inverse;
}

void rigid_pose_interpolate(const rigid_pose_t *a, const rigid_pose_t *b, double fraction, rigid_pose_t *pose) {
    for (int i = 0; i < 3; i++) {
        pose->position_m[i] = a->position_m[i] + fraction * (b->position_m[i] - a->position_m[i]);
    }
    rotation_interpolate(a->rotation, b->rotation, fraction, pose->rotation);
}

void rigid_pose_choose_side(rigid_pose_t *pose, const rigid_pose_t *reference) {
    if (rotation_dot(pose->rotation, reference->rotation) < 0.0) {
        for (int i = 0; i < 4; i++) {
            pose->rotation[i] = -pose->rotation[i];
        }
    }
}
