/* Applies the firmware's mathematics to arrays from Python. Each function processes the rows one by one, with functions
 * of the firmware. Arrays are dense and row-major. `out` must not overlap the inputs. */
#ifndef COMANIP_BATCH_H
#define COMANIP_BATCH_H

#include <stddef.h>

#include "../../../firmware/control/arm_ik.h"

void batch_multiply(size_t count, const dual_quaternion_t a[], const dual_quaternion_t b[], dual_quaternion_t out[]);
void batch_conjugate(size_t count, const dual_quaternion_t a[], dual_quaternion_t out[]);
void batch_normalise(size_t count, const dual_quaternion_t a[], dual_quaternion_t out[]);
void batch_decompositional_multiply(size_t count, const dual_quaternion_t a[], const dual_quaternion_t b[],
                                    dual_quaternion_t out[]);

/* matrix: count x 9. */
void batch_pose_from_matrix(size_t count, const float matrix[], const vector3_t translation_m[],
                            dual_quaternion_t out[]);

/* position_rad: count x joint_count. */
void batch_forward_kinematics(const arm_t *arm, size_t count, const float position_rad[], dual_quaternion_t out[]);

/* out: count x 8 x joint_count. */
void batch_pose_jacobian(const arm_t *arm, size_t count, const float position_rad[], float out[]);

/* out: count x joint_count. */
void batch_joint_velocity(const arm_ik_t *ik, const differential_ik_config_t *config, size_t count,
                          const float position_rad[], const dual_quaternion_t target[], float out[]);

#endif
