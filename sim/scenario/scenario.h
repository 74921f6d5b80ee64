/* A scenario as data: where the arm starts, what stands around, who is there and moves how, what the operator does
 * when, and what must come out. Read from a YAML file (scenario_file.h); docs/scenario-files.md explains every key. SI
 * units; poses and points are in torso axes (x forward, y left, z up) unless said otherwise. */
#ifndef COMANIP_SIM_SCENARIO_H
#define COMANIP_SIM_SCENARIO_H

#include <stdbool.h>
#include <stddef.h>

#include "../../firmware/parameters/parameters.h"
#include "../../firmware/protocol/can_protocol.h"
#include "../common/events.h"
#include "../common/rigid_pose.h"
#include "../robot/robot_model.h"

#define SCENARIO_NAME_BYTES 32
#define SCENARIO_TEXT_BYTES 160
#define SCENARIO_PATH_BYTES 512
#define SCENARIO_MAX_TASKS 8
#define SCENARIO_MAX_OBJECTS 8
#define SCENARIO_MAX_POINTS 4
#define SCENARIO_MAX_PEOPLE 2
#define SCENARIO_MAX_STEPS 40  /* of one person's program, of the operator's script */
#define SCENARIO_MAX_AWAITED 3 /* events that a step waits for */
#define SCENARIO_MAX_CHECKS 24

typedef char scenario_name_t[SCENARIO_NAME_BYTES];

/* ---- things */

/* A cup open at its top: its frame lies in the centre of the inner bottom, z points to the opening. */
typedef struct {
    bool present;
    double radius_m, height_m; /* inside */
    double wall_m;
    rigid_pose_t mount; /* seen from the hand that carries it */
} cup_t;

/* In the robot's cup at the start. */
typedef struct {
    int particles; /* 0: a scenario without water */
    double particle_radius_m;
    double density_kgpm3; /* of a particle */
} water_t;

typedef enum {
    OBJECT_ROD,   /* rigid cylinder along its z axis: the pipe, a baton, a bottle */
    OBJECT_CRANK, /* turns on a fixed hinge along the object's z axis; its handle is parallel to it, radius_m away */
    OBJECT_STAND, /* fixed box that a rod can lie on */
} object_kind_t;

typedef enum {
    GRIP_FIXED, /* all six directions */
    GRIP_BALL,  /* the object turns freely in the grip */
} grip_kind_t;

typedef struct {
    scenario_name_t name;
    double along_m; /* on the axis of a rod, of a crank's handle; from its middle */
} object_point_t;

typedef struct {
    scenario_name_t name;
    object_kind_t kind;
    rigid_pose_t pose;       /* of its middle at the start; crank: of the hinge, the handle at +x */
    double length_m;         /* rod; crank: of the handle */
    double radius_m;         /* rod; crank: from the hinge to the handle's axis */
    double size_m[3];        /* stand */
    double mass_kg;          /* rod; crank: of the handle with its arm */
    double damping_Nmspprad; /* crank: N m s/rad */
    double friction_Nm;      /* crank: dry */
    grip_kind_t robot_grip, person_grip;
    bool held_by_robot; /* rod: in the closed gripper from the start on */
    object_point_t point[SCENARIO_MAX_POINTS];
    size_t point_count;
} object_t;

#define OBJECT_HANDLE_RADIUS_M 0.01 /* how thick a crank's handle is */

/* The robot's gripper: two padded jaws, compliant, and slipping beyond a load. */
typedef struct {
    double offset_m[3];                    /* its middle in the frame of the robot's hand */
    double stroke_s;                       /* from open to closed */
    double capture_m;                      /* an axis so close to its middle is gripped as the jaws close */
    double stiffness_Npm, damping_Nspm;    /* of the pads, along each axis */
    double force_limit_N, torque_limit_Nm; /* more, and the object slips out */
} gripper_t;

/* ---- points that a hand can aim at */

typedef enum {
    POINT_NONE,
    POINT_OBJECT,      /* a point of object[index] */
    POINT_PERSON_GRIP, /* of person[index] */
    POINT_ROBOT_GRIPPER,
} point_kind_t;

typedef struct {
    point_kind_t kind;
    size_t index;
    size_t point; /* of the object's */
} point_t;

/* ---- when a step begins */

typedef struct {
    double at_s;                       /* not before; 0: at once */
    int awaited[SCENARIO_MAX_AWAITED]; /* numbers in scenario.events: all must have happened */
    size_t awaited_count;
    double delay_s;    /* after the last of them */
    double patience_s; /* of waiting for them; beyond, the run has failed. 0: up to the end */
} step_start_t;

/* ---- people */

typedef enum {
    PERSON_REST,  /* stays where it is for duration_s */
    PERSON_MOVE,  /* to displacement_m and rotation_vector_rad from the start, minimum jerk */
    PERSON_REACH, /* brings its own grip to the point `to` */
    PERSON_GUIDE, /* brings the point `what`, which the robot carries, to the point `to`, by moving its own hand */
    PERSON_PLAY,  /* plays the recording from here on */
    PERSON_GRIP,  /* closes the hand on the object */
    PERSON_RELEASE,
    PERSON_TURN, /* turns the crank that it holds */
} person_action_t;

typedef struct {
    scenario_name_t name; /* "": none. Done, it raises "PERSON.NAME" */
    person_action_t action;
    step_start_t start;
    double duration_s;                     /* rest, move, reach, guide; turn: per turn */
    double displacement_m[3];              /* move: from the start; play: none */
    double rotation_vector_rad[3];         /* move: from the start orientation, torso axes */
    bool from_here;                        /* move: both count from the end of the step before, not from the start */
    point_t what, to;                      /* guide: both; reach: to */
    double offset_m[3];                    /* reach, guide: added to `to` */
    double tolerance_m;                    /* reach, guide: corrected in short moves until it is met */
    double lift_m;                         /* reach, guide: the way bows upwards by so much */
    size_t object;                         /* grip, turn */
    double turns;                          /* turn: signed, about the hinge's axis */
    char recording[SCENARIO_PATH_BYTES];   /* play; "": the one of the command line */
    char axes[8];                          /* play; "": by the file's name */
    double position_scale, rotation_scale; /* play: of the displacement from the recording's first pose */
    double from_s, until_s;                /* play: which part; until_s 0: to its end */
} person_step_t;

#define PERSON_GYRATION_M 0.06

typedef struct {
    scenario_name_t name;
    bool tracked;       /* wears the marker; one person does */
    rigid_pose_t start; /* of the hand. Hand frame as the robot's: z forward along the forearm, x up, palm down */
    double grip_m[3];   /* where it holds things, in the hand's frame */
    double elbow_m[3];  /* at the start; the forearm points there */
    double mass_kg;     /* of hand and forearm as the hand feels it; their radius of gyration: PERSON_GYRATION_M */
    double stiffness_Npm, damping_ratio; /* of the arm against what pulls at the hand */
    double stiffness_Nmprad;             /* of the wrist */
    double grip_force_limit_N;
    double tremor_mm; /* RMS, all axes together */
    cup_t cup;
    person_step_t step[SCENARIO_MAX_STEPS];
    size_t step_count;
    person_step_t recorded_step[SCENARIO_MAX_STEPS]; /* in place of them when a recording is given */
    size_t recorded_step_count;
    int done_event; /* "PERSON.done" */
} person_t;

/* ---- the operator */

typedef enum {
    OPERATE_COMMAND, /* start, latch, clutch, stop; select of a built-in task */
    OPERATE_DEFINE,  /* select of one of the scenario's own tasks */
    OPERATE_GRIPPER, /* open or close */
} operate_kind_t;

typedef struct {
    scenario_name_t name; /* "": none. Acknowledged, it raises "operator.NAME" */
    step_start_t start;
    operate_kind_t kind;
    command_t command;
    task_id_t task;  /* select of a built-in task */
    size_t own_task; /* OPERATE_DEFINE */
    bool close;      /* OPERATE_GRIPPER */
} operate_step_t;

typedef struct {
    scenario_name_t name;
    task_define_t define;
} own_task_t;

/* ---- what must come out */

typedef enum {
    MEASURE_SETTLED_POSITION, /* mm, largest distance between ODE's hand and the target */
    MEASURE_FOLLOWING_RMS,    /* mm, of the same */
    MEASURE_RELATION_RMS,     /* mm, way of ODE's hand since `from` less the person's times motion_scale */
    MEASURE_DISPLACEMENT,     /* mm, way of ODE's hand from `from` to `until` less expected_m times motion_scale */
    MEASURE_WAY_X,
    MEASURE_WAY_Y,
    MEASURE_WAY_Z,             /* mm, ODE's hand along this axis from `from` to `until`; signed */
    MEASURE_TILT,              /* deg, least angle between torso z and the hand's axis that was along it at the start */
    MEASURE_CUP_TILT_PEAK,     /* deg, largest angle between torso z and the axis of the robot's cup */
    MEASURE_TURN,              /* deg, by which the hand has turned from `from` to `until`, less expected_deg */
    MEASURE_WATER_POURED,      /* %, of the particles, that left the robot's cup */
    MEASURE_WATER_CAUGHT,      /* %, of these, that are in the person's cup at the end */
    MEASURE_FLOW_WHILE_MOVING, /* particles that left while the person's hand moved faster than 5 mm/s */
    MEASURE_DROPS,             /* times that the object was held by nobody after its first grip, or slipped out */
    MEASURE_HELD,              /* 1 if the named person (and nobody else) holds the object at the end */
    MEASURE_FORCE_RMS,         /* N, at the person's hand, from ODE's joint, while it holds the object */
    MEASURE_FORCE_PEAK,
    MEASURE_TURNS,          /* of the crank */
    MEASURE_CARRIED_FOR,    /* s, that robot and person hold the object together */
    MEASURE_CLEARANCE,      /* mm, least between person and robot outside intended contact */
    MEASURE_SELF_CLEARANCE, /* mm, least between arm and robot */
    MEASURE_AIM,            /* mm, mean of where ODE's hand is from the person's, less expected_m; torso axes */
} measure_t;

/* A time of the run, or an event and so long after it. */
typedef struct {
    int event; /* EVENT_NONE: `s` counts from the run's start */
    double s;
} moment_t;

typedef struct {
    scenario_name_t name;
    measure_t measure;
    moment_t from, until;     /* the window. A single instant: `until` */
    bool has_from, has_until; /* else as check_window.h says */
    double expected_m[3];
    double expected_deg;
    size_t object, person;
    double limit;
    bool is_lower_bound; /* at least the limit; else at most */
} scenario_check_t;

/* How much of it the seed varies: uniform, plus or minus. */
typedef struct {
    double start_m;          /* where the tracked person's hand is at the start, per axis */
    double move_m;           /* where each move ends, per axis; moves to one place stay moves to one place */
    double object_m[3];      /* where the objects stand, all alike */
    double duration_percent; /* of the time of each step that has one */
} variation_t;

typedef struct {
    scenario_name_t name;
    char summary[SCENARIO_TEXT_BYTES];
    char path[SCENARIO_PATH_BYTES];
    double
        duration_s; /* the longest it may take; the operator stops SCENARIO_STOP_BEFORE_END_S before it at the latest */
    double start_deg[ROBOT_JOINTS];
    bool parameter_written[PARAMETER_COUNT];
    float parameter_value[PARAMETER_COUNT];
    own_task_t own_task[SCENARIO_MAX_TASKS];
    size_t own_task_count;
    gripper_t gripper;
    cup_t cup; /* on the back of the robot's hand */
    water_t water;
    object_t object[SCENARIO_MAX_OBJECTS];
    size_t object_count;
    person_t person[SCENARIO_MAX_PEOPLE];
    size_t person_count;
    size_t tracked; /* person */
    operate_step_t operate[SCENARIO_MAX_STEPS];
    size_t operate_count;
    scenario_check_t check[SCENARIO_MAX_CHECKS];
    size_t check_count;
    double tracking_rms_limit_mm, tracking_max_limit_mm; /* 0: not checked */
    double followable_min_percent;                       /* 0: not checked */
    variation_t variation;
    events_t events; /* all that can happen, none happened yet */
} scenario_t;

#define SCENARIO_STOP_BEFORE_END_S 0.5 /* the operator's stop */

/* Seed 0 changes nothing; any other draws start, moves, places and times within `variation`. */
void scenario_vary(scenario_t *self, uint64_t seed);

#endif
