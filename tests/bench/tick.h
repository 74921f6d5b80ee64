/* Our tick behind C's interface: compiled as the product is. */
#ifndef COMANIP_BENCH_TICK_H
#define COMANIP_BENCH_TICK_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tick tick_t;

/* A pose is w x y z, x y z. fixed: joint_count + 1 of them, the effector's last; hands: as many as hand_count. name: of
 * an arm that `make arms` wrote; NULL: the table with the law for any arm. */
typedef struct {
    const char *name;
    int joint_count, hand_count;
    const double *fixed, *hands, *start_rad;
    double weight[2], gain_per_s[2], damping; /* rotation, translation */
} tick_model_t;

tick_t *tick_create(const tick_model_t *model);
void tick_set(tick_t *self, const double position_rad[]);
void tick_run(tick_t *self, int count);
void tick_once(tick_t *self, int hand, double velocity_radps[]);

#ifdef __cplusplus
}
#endif

#endif
