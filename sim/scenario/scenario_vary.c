/* Varies a scenario at random. The seed determines the variation. */
#include <stdio.h>
#include <string.h>

#include "../common/random.h"
#include "scenario.h"

/* Returns a uniform random number from -1 to 1. */
static double draw(random_t *random) {
    return 2.0 * random_uniform(random) - 1.0;
}

static void vary_objects(scenario_t *self, uint64_t seed) {
    random_t random;
    double shift_m[3];
    random_init(&random, seed, "scenario objects");
    for (int k = 0; k < 3; k++) {
        shift_m[k] = self->variation.object_m[k] * draw(&random);
    }
    for (size_t i = 0; i < self->object_count; i++) {
        for (int k = 0; k < 3 && !self->object[i].held_by_robot; k++) {
            self->object[i].pose.position_m[k] += shift_m[k];
        }
    }
}

static void vary_start(scenario_t *self, uint64_t seed) {
    random_t random;
    random_init(&random, seed, "scenario start");
    person_t *person = &self->person[self->tracked];
    for (int k = 0; k < 3; k++) {
        const double shift_m = self->variation.start_m * draw(&random);
        person->start.position_m[k] += shift_m;
        person->elbow_m[k] += shift_m;
    }
}

static bool is_same_target(const person_step_t *a, const person_step_t *b) {
    return a->action == PERSON_MOVE && b->action == PERSON_MOVE && !a->from_here && !b->from_here &&
           memcmp(a->displacement_m, b->displacement_m, sizeof a->displacement_m) == 0;
}

/* All moves to the same position (for example home) get the same random shift, so that they still end at the same
 * position. */
static void vary_steps(const variation_t *variation, person_step_t steps[], size_t count, random_t *random) {
    person_step_t original[SCENARIO_MAX_STEPS];
    memcpy(original, steps, count * sizeof steps[0]);
    for (size_t i = 0; i < count; i++) {
        const double stretch = 1.0 + 0.01 * variation->duration_percent * draw(random);
        double shift_m[3];
        for (int k = 0; k < 3; k++) {
            shift_m[k] = variation->move_m * draw(random);
        }
        if (steps[i].action != PERSON_GRIP && steps[i].action != PERSON_RELEASE) {
            steps[i].duration_s *= stretch;
        }
        if (steps[i].action != PERSON_MOVE || steps[i].from_here) {
            continue;
        }
        size_t first = 0;
        while (!is_same_target(&original[first], &original[i])) {
            first++;
        }
        for (int k = 0; k < 3; k++) {
            steps[i].displacement_m[k] =
                first < i ? steps[first].displacement_m[k] : original[i].displacement_m[k] + shift_m[k];
        }
    }
}

static void vary_program(const scenario_t *self, uint64_t seed, const char *person, const char *program,
                         person_step_t steps[], size_t count) {
    char stream[2 * SCENARIO_NAME_BYTES];
    random_t random;
    (void)snprintf(stream, sizeof stream, "scenario %s %s", program, person);
    random_init(&random, seed, stream);
    vary_steps(&self->variation, steps, count, &random);
}

void scenario_vary(scenario_t *self, uint64_t seed) {
    if (seed == 0) {
        return;
    }
    vary_objects(self, seed);
    vary_start(self, seed);
    for (size_t i = 0; i < self->person_count; i++) {
        person_t *person = &self->person[i];
        vary_program(self, seed, person->name, "program", person->step, person->step_count);
        vary_program(self, seed, person->name, "recording", person->recorded_step, person->recorded_step_count);
    }
}
