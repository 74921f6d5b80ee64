#include "proximity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bodies.h"
#include "comanip_schema.h"

#define BODY_PARTS (BODIES_ROBOT_PARTS - ROBOT_PART_UPPER_ARM)
#define PERSON_PAIRS (SCENARIO_MAX_PEOPLE * BODIES_PERSON_PARTS * BODIES_ROBOT_PARTS)
#define SELF_PAIRS (ROBOT_PART_UPPER_ARM * BODY_PARTS)

/* A pair's distance is computed up to this much beyond the smallest distance found so far. A pair that is farther apart
 * need not be searched again until its bodies have travelled about this far. */
#define SEARCH_BEYOND_M 0.03

typedef struct {
    const body_t *a, *b;
    int number;
    double distance_m;  /* result of the last search; negative before the first search */
    double least_m;     /* lower bound at the last search */
    double travelled_m; /* sum of both bodies' travelled_m at the last search */
} pair_t;

typedef struct {
    pair_t pair[PERSON_PAIRS];
    size_t count;
    size_t nearest; /* index in `pair` of the last search's nearest pair, where the next search begins */
} pairs_t;

struct proximity {
    const scenario_t *scenario;
    const scene_t *scene;
    bodies_t bodies;
    pairs_t with_person, with_itself;
    bool person_grips[SCENARIO_MAX_PEOPLE][SCENARIO_MAX_OBJECTS];
    bool robot_grips[SCENARIO_MAX_OBJECTS];
    char name[PERSON_PAIRS + SELF_PAIRS][PROXIMITY_PAIR_BYTES];
};

proximity_pair_t proximity_pair(int pair) {
    if (pair >= PERSON_PAIRS) {
        const int number = pair - PERSON_PAIRS;
        return (proximity_pair_t){.person = -1,
                                  .robot = (robot_part_t)(number / BODY_PARTS),
                                  .body = (robot_part_t)(ROBOT_PART_UPPER_ARM + number % BODY_PARTS)};
    }
    return (proximity_pair_t){.person = pair / (BODIES_PERSON_PARTS * BODIES_ROBOT_PARTS),
                              .part = (person_part_t)(pair / BODIES_ROBOT_PARTS % BODIES_PERSON_PARTS),
                              .robot = (robot_part_t)(pair % BODIES_ROBOT_PARTS)};
}

/* ---- pairs */

/* Finds the objects that the people and the robot may grip in this scenario. If the gripper closes at all, it may grip
 * any object, because it grips whatever is between its jaws. */
static void find_grips(proximity_t *self, const scenario_t *scenario) {
    bool closes = false;
    for (size_t i = 0; i < scenario->operate_count; i++) {
        closes = closes || (scenario->operate[i].kind == OPERATE_GRIPPER && scenario->operate[i].close);
    }
    for (size_t i = 0; i < scenario->object_count; i++) {
        self->robot_grips[i] = closes || scenario->object[i].held_by_robot;
    }
    for (size_t p = 0; p < scenario->person_count; p++) {
        const person_t *who = &scenario->person[p];
        for (size_t i = 0; i < who->step_count + who->recorded_step_count; i++) {
            const person_step_t *step = i < who->step_count ? &who->step[i] : &who->recorded_step[i - who->step_count];
            if (step->action == PERSON_GRIP) {
                self->person_grips[p][step->object] = true;
            }
        }
    }
}

/* Returns true if contact of the pair is intended. This is so if both parts are the same rod, held by person and robot
 * together, or if one part is a rod and the other is a hand, gripper or forearm that may hold this rod in this
 * scenario. */
static bool is_intended(const proximity_t *self, int number) {
    const proximity_pair_t parts = proximity_pair(number);
    if (parts.person < 0) {
        return false;
    }
    const int of_robot = parts.robot == ROBOT_PART_HELD ? self->bodies.robot[ROBOT_PART_HELD].object : BODY_NO_OBJECT;
    const int of_person =
        parts.part == PERSON_PART_HELD ? self->bodies.person[parts.person][PERSON_PART_HELD].object : BODY_NO_OBJECT;
    const bool by_hand = parts.part == PERSON_PART_HAND || parts.part == PERSON_PART_FOREARM;
    const bool by_gripper = parts.robot == ROBOT_PART_GRIPPER || parts.robot == ROBOT_PART_FOREARM;
    return (of_robot != BODY_NO_OBJECT && of_robot == of_person) ||
           (of_robot != BODY_NO_OBJECT && by_hand && self->person_grips[parts.person][of_robot]) ||
           (of_person != BODY_NO_OBJECT && by_gripper && self->robot_grips[of_person]);
}

static void add_pair(pairs_t *self, const body_t *a, const body_t *b, int number) {
    self->pair[self->count++] = (pair_t){.a = a, .b = b, .number = number, .distance_m = -1.0};
}

/* Returns true if the two parts are neighbours in the kinematic chain, because such parts always touch. */
static bool are_neighbours(const proximity_pair_t *parts) {
    return parts->robot == ROBOT_PART_FOREARM && parts->body == ROBOT_PART_UPPER_ARM;
}

static void add_pairs(proximity_t *self) {
    static const char *const person_part[] = {COMANIP_CLEARANCE_PERSON_PART_NAMES};
    static const char *const robot_part[] = {COMANIP_CLEARANCE_ROBOT_PART_NAMES};
    const bodies_t *bodies = &self->bodies;
    for (int i = 0; i < PERSON_PAIRS + SELF_PAIRS; i++) {
        const proximity_pair_t parts = proximity_pair(i);
        const body_t *robot = &bodies->robot[parts.robot];
        if (parts.person < 0) {
            (void)snprintf(self->name[i], sizeof self->name[i], "robot.%s - robot.%s", robot_part[parts.robot],
                           robot_part[parts.body]);
            if (!are_neighbours(&parts)) {
                add_pair(&self->with_itself, robot, &bodies->robot[parts.body], i);
            }
        } else if ((size_t)parts.person < self->scenario->person_count) {
            (void)snprintf(self->name[i], sizeof self->name[i], "%s.%s - robot.%s",
                           self->scenario->person[parts.person].name, person_part[parts.part], robot_part[parts.robot]);
            add_pair(&self->with_person, &bodies->person[parts.person][parts.part], robot, i);
        }
    }
}

/* ---- smallest distance */

/* Returns the smallest distance of all pairs. Searches only the pairs that may be the nearest; the others were too far
 * apart at their last search and have not travelled far enough since. */
static double search(const proximity_t *self, pairs_t *pairs, int *number) {
    double best_m = PROXIMITY_CEILING_M;
    const size_t first = pairs->nearest;
    *number = -1;
    for (size_t i = 0; i < pairs->count; i++) {
        const size_t slot = (first + i) % pairs->count;
        pair_t *pair = &pairs->pair[slot];
        const double travelled_m = pair->a->travelled_m + pair->b->travelled_m;
        const double least_m = pair->least_m - (travelled_m - pair->travelled_m);
        if (!pair->a->present || !pair->b->present || least_m >= best_m || is_intended(self, pair->number)) {
            continue;
        }
        const double ceiling_m = fmin(best_m + SEARCH_BEYOND_M, PROXIMITY_CEILING_M);
        pair->distance_m = convex_distance_m(&pair->a->shape, &pair->b->shape, ceiling_m, pair->distance_m);
        pair->least_m = pair->distance_m - CONVEX_DISTANCE_ERROR_M;
        pair->travelled_m = travelled_m;
        if (pair->distance_m < best_m) {
            best_m = pair->distance_m;
            *number = pair->number;
            pairs->nearest = slot;
        }
    }
    return best_m;
}

proximity_t *proximity_create(const scenario_t *scenario, const scene_t *scene) {
    proximity_t *self = calloc(1, sizeof *self);
    if (self != NULL) {
        self->scenario = scenario;
        self->scene = scene;
        bodies_init(&self->bodies, scenario);
        find_grips(self, scenario);
        add_pairs(self);
    }
    return self;
}

void proximity_destroy(proximity_t *self) {
    free(self);
}

measured_clearance_t proximity_measure(proximity_t *self) {
    measured_clearance_t clearance;
    bodies_place(&self->bodies, self->scenario, self->scene);
    clearance.person_m = search(self, &self->with_person, &clearance.person_pair);
    clearance.self_m = search(self, &self->with_itself, &clearance.self_pair);
    return clearance;
}

const char *proximity_pair_name(const proximity_t *self, int pair) {
    return pair >= 0 && pair < PERSON_PAIRS + SELF_PAIRS ? self->name[pair] : "";
}
