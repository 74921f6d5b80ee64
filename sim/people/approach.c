#include "approach.h"

#include <math.h>

#define CORRECTION_S 0.4
#define MAX_CORRECTIONS 10
#define SETTLE_S 0.15 /* time for the robot to settle after the guiding hand has stopped */
#define TIME_TOLERANCE_S 1e-9

/* Computes the vector from the moved point to its goal. The moved point is the person's own grip or, if the person
 * guides the robot, a point that the robot carries. */
static void read_error(const approach_t *self, double error_m[3]) {
    const person_step_t *step = self->step;
    const point_t own_grip = {.kind = POINT_PERSON_GRIP, .index = self->person};
    double point_m[3], goal_m[3];
    scene_point(self->scene, step->action == PERSON_GUIDE ? &step->what : &own_grip, point_m);
    scene_point(self->scene, &step->to, goal_m);
    for (int i = 0; i < 3; i++) {
        error_m[i] = goal_m[i] + step->offset_m[i] - point_m[i];
    }
}

static void begin_move(approach_t *self, const rigid_pose_t *aim, const double robot_gain[3], const double error_m[3],
                       double lift_m, double begin_s, double duration_s) {
    double move_m[3] = {error_m[0], error_m[1], error_m[2]};
    double bow_m[3] = {0.0, 0.0, lift_m};
    rigid_pose_t goal = *aim;
    for (int i = 0; i < 3; i++) {
        if (self->step->action == PERSON_GUIDE) {
            move_m[i] /= robot_gain[i];
            bow_m[i] /= robot_gain[i];
        }
        goal.position_m[i] += move_m[i];
    }
    hand_path_init(&self->path, aim, &goal, bow_m, begin_s, duration_s);
}

void approach_begin(approach_t *self, const rigid_pose_t *aim, const double robot_gain[3], double begin_s) {
    double error_m[3];
    read_error(self, error_m);
    self->corrections = 0;
    begin_move(self, aim, robot_gain, error_m, self->step->lift_m, begin_s, self->step->duration_s);
}

/* Returns the time at which the hand has finished its last move and, if the hand guides the robot, the robot has
 * settled. */
static double end_s(const approach_t *self) {
    const double settle_s = self->step->action == PERSON_GUIDE ? SETTLE_S : 0.0;
    return self->path.begin_s + self->path.duration_s + settle_s;
}

approach_status_t approach_update(approach_t *self, const double robot_gain[3], double now_s, double *miss_m) {
    if (now_s < end_s(self) - TIME_TOLERANCE_S) {
        return APPROACH_MOVES;
    }
    double error_m[3];
    read_error(self, error_m);
    *miss_m = sqrt(error_m[0] * error_m[0] + error_m[1] * error_m[1] + error_m[2] * error_m[2]);
    if (*miss_m <= self->step->tolerance_m) {
        return APPROACH_THERE;
    }
    if (self->corrections == MAX_CORRECTIONS) {
        return APPROACH_FAILED;
    }
    self->corrections++;
    const rigid_pose_t aim = self->path.to;
    begin_move(self, &aim, robot_gain, error_m, 0.0, now_s, CORRECTION_S);
    return APPROACH_MOVES;
}
