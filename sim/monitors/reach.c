#include "reach.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "../robot/position_jacobian.h"

#define MAX_ITERATIONS 40
#define DAMPING_START 1e-4 /* m^2; small compared with the squared singular values of the Jacobian, 1e-3 to 1e-1 */
#define DAMPING_MIN 1e-9
#define DAMPING_MAX 1e3
#define STEP_MIN_RAD 1e-6
#define GRID_STARTS 8
#define FAR_RESERVE 0.1 /* assumed largest error of a distance that the search found, as a share of this distance */

typedef struct {
    double position_rad[ROBOT_JOINTS];
    double error_m[3]; /* vector from the end effector to the target */
    double distance_m;
} candidate_t;

static double limit(double value, double minimum, double maximum) {
    return value < minimum ? minimum : value > maximum ? maximum : value;
}

/* Computes the error and the distance of a posture, and also its Jacobian unless `jacobian` is NULL. */
static void evaluate(candidate_t *self, const double target_m[3], double jacobian[ROBOT_JOINTS][3]) {
    double hand_m[3], square = 0.0;
    position_jacobian(self->position_rad, hand_m, jacobian);
    for (size_t k = 0; k < 3; k++) {
        self->error_m[k] = target_m[k] - hand_m[k];
        square += self->error_m[k] * self->error_m[k];
    }
    self->distance_m = sqrt(square);
}

/* Excludes from the step each joint that is at a limit and would be moved beyond this limit. */
static void find_free_joints(const candidate_t *self, double jacobian[ROBOT_JOINTS][3], bool is_free[ROBOT_JOINTS]) {
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const double pull =
            jacobian[i][0] * self->error_m[0] + jacobian[i][1] * self->error_m[1] + jacobian[i][2] * self->error_m[2];
        is_free[i] = !(self->position_rad[i] <= robot_model_position_min_rad(i) && pull < 0.0) &&
                     !(self->position_rad[i] >= robot_model_position_max_rad(i) && pull > 0.0);
    }
}

/* Makes the damped Gauss-Newton step J^T (J J^T + damping I)^-1 e of the free joints, projected onto the limits.
 * Returns the step's largest component. */
static double step(const candidate_t *from, double jacobian[ROBOT_JOINTS][3], const bool is_free[ROBOT_JOINTS],
                   double damping, candidate_t *to) {
    double x[3], largest_rad = 0.0;
    position_jacobian_solve((const double (*)[3])jacobian, is_free, damping, from->error_m, x);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const double step_rad = jacobian[i][0] * x[0] + jacobian[i][1] * x[1] + jacobian[i][2] * x[2];
        to->position_rad[i] = limit(from->position_rad[i] + (is_free[i] ? step_rad : 0.0),
                                    robot_model_position_min_rad(i), robot_model_position_max_rad(i));
        largest_rad = fmax(largest_rad, fabs(to->position_rad[i] - from->position_rad[i]));
    }
    return largest_rad;
}

/* Runs the Levenberg-Marquardt method from one posture. */
static candidate_t descend(const double start_rad[ROBOT_JOINTS], const double target_m[3]) {
    candidate_t best;
    double jacobian[ROBOT_JOINTS][3];
    bool is_free[ROBOT_JOINTS];
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        best.position_rad[i] = limit(start_rad[i], robot_model_position_min_rad(i), robot_model_position_max_rad(i));
    }
    evaluate(&best, target_m, jacobian);
    double damping = DAMPING_START;
    for (int n = 0; n < MAX_ITERATIONS && best.distance_m > REACH_TOLERANCE_M / 10.0; n++) {
        candidate_t next;
        find_free_joints(&best, jacobian, is_free);
        const double largest_rad = step(&best, jacobian, is_free, damping, &next);
        evaluate(&next, target_m, NULL);
        if (next.distance_m < best.distance_m) {
            best = next;
            evaluate(&best, target_m, jacobian);
            damping = fmax(damping / 10.0, DAMPING_MIN);
        } else {
            damping *= 10.0;
        }
        if (largest_rad < STEP_MIN_RAD || damping > DAMPING_MAX) {
            break;
        }
    }
    return best;
}

static void grid_posture(size_t index, double position_rad[ROBOT_JOINTS]) {
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const double share = (double)(index % REACH_GRID) / (REACH_GRID - 1);
        const double minimum_rad = robot_model_position_min_rad(i);
        position_rad[i] = minimum_rad + share * (robot_model_position_max_rad(i) - minimum_rad);
        index /= REACH_GRID;
    }
}

void reach_init(reach_t *self) {
    memset(self, 0, sizeof *self);
    for (size_t n = 0; n < REACH_POSTURES; n++) {
        double position_rad[ROBOT_JOINTS];
        transform_t hand;
        grid_posture(n, position_rad);
        robot_model_forward(position_rad, NULL, &hand);
        memcpy(self->hand_m[n], hand.position_m, sizeof self->hand_m[n]);
    }
    grid_posture(REACH_POSTURES / 2, self->position_rad);
}

/* Finds the GRID_STARTS postures of the grid that come closest to the target, closest first. */
static void nearest_postures(const reach_t *self, const double target_m[3], size_t nearest[GRID_STARTS]) {
    double square[GRID_STARTS];
    size_t count = 0;
    for (size_t n = 0; n < REACH_POSTURES; n++) {
        const double *hand_m = self->hand_m[n];
        const double dx = hand_m[0] - target_m[0], dy = hand_m[1] - target_m[1], dz = hand_m[2] - target_m[2];
        const double distance = dx * dx + dy * dy + dz * dz;
        if (count == GRID_STARTS && distance >= square[count - 1]) {
            continue;
        }
        size_t slot = count < GRID_STARTS ? count++ : count - 1;
        for (; slot > 0 && distance < square[slot - 1]; slot--) {
            square[slot] = square[slot - 1];
            nearest[slot] = nearest[slot - 1];
        }
        square[slot] = distance;
        nearest[slot] = n;
    }
}

static void improve(candidate_t *best, const double start_rad[ROBOT_JOINTS], const double target_m[3]) {
    const candidate_t candidate = descend(start_rad, target_m);
    if (candidate.distance_m < best->distance_m) {
        *best = candidate;
    }
}

double reach_distance_m(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]) {
    candidate_t best = descend(self->position_rad, target_m);
    if (best.distance_m > REACH_TOLERANCE_M) {
        improve(&best, measured_rad, target_m);
    }
    if (best.distance_m > REACH_TOLERANCE_M) {
        size_t nearest[GRID_STARTS];
        nearest_postures(self, target_m, nearest);
        for (size_t n = 0; n < GRID_STARTS && best.distance_m > REACH_TOLERANCE_M; n++) {
            double start_rad[ROBOT_JOINTS];
            grid_posture(nearest[n], start_rad);
            improve(&best, start_rad, target_m);
        }
    }
    memcpy(self->position_rad, best.position_rad, sizeof self->position_rad);
    memcpy(self->target_m, target_m, sizeof self->target_m);
    self->distance_m = best.distance_m;
    self->searched = true;
    return best.distance_m;
}

bool reach_contains(reach_t *self, const double target_m[3], const double measured_rad[ROBOT_JOINTS]) {
    if (self->searched) {
        const double moved_m =
            sqrt(pow(target_m[0] - self->target_m[0], 2.0) + pow(target_m[1] - self->target_m[1], 2.0) +
                 pow(target_m[2] - self->target_m[2], 2.0));
        if (self->distance_m + moved_m <= REACH_TOLERANCE_M) {
            return true;
        }
        if ((1.0 - FAR_RESERVE) * self->distance_m - moved_m > REACH_TOLERANCE_M) {
            return false;
        }
    }
    return reach_distance_m(self, target_m, measured_rad) <= REACH_TOLERANCE_M;
}
