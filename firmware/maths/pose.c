/* Poses as rotation and translation: see pose.h. */
#include "pose.h"

const pose_t pose_identity = {{1.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};

pose_t pose_from_dual_quaternion(dual_quaternion_t pose) {
    return (pose_t){pose.primary, dual_quaternion_translation(pose)};
}

dual_quaternion_t pose_to_dual_quaternion(pose_t pose) {
    return dual_quaternion_from_pose(pose.rotation, pose.translation_m);
}

pose_t pose_multiply(pose_t a, pose_t b) {
    return (pose_t){
        quaternion_multiply(a.rotation, b.rotation),
        vector3_add(a.translation_m, quaternion_rotate(a.rotation, b.translation_m)),
    };
}

pose_t pose_interpolate(pose_t a, pose_t b, float s) {
    const vector3_t way = vector3_add(b.translation_m, vector3_scale(a.translation_m, -1.0f));
    return (pose_t){
        quaternion_interpolate(a.rotation, b.rotation, s),
        vector3_add(a.translation_m, vector3_scale(way, s)),
    };
}
