/* A scenario as data: the arm's start posture, the objects, the people and their motion, the operator's script, and the
 * checks. It is read from a YAML file (scenario_file.h); docs/scenario-files.md explains every key. SI units; poses and
 * points are in torso axes (x forward, y left, z up) unless stated otherwise. */
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
#define SCENARIO_MAX_STEPS 40  /* steps in a person's program or the operator's script */
#define SCENARIO_MAX_AWAITED 3 /* number of events that one step can wait for */
#define SCENARIO_MAX_CHECKS 24

typedef char scenario_name_t[SCENARIO_NAME_BYTES];

/* ---- objects */

/* An open cup. The origin of its frame is the centre of the inner bottom; z points to the opening. */
typedef struct {
    bool present;
    double radius_m, height_m; /* inner dimensions */
    double wall_m;
    rigid_pose_t mount; /* pose of the cup in the frame of the hand that carries the cup */
} cup_t;

/* Water in the robot's cup at the start. */
typedef struct {
    int particles; /* 0 if the scenario has no water */
    double particle_radius_m;
    double density_kgpm3; /* density of a particle */
} water_t;

typedef enum {
    OBJECT_ROD,   /* rigid cylinder along its z axis, for example a pipe or a baton */
    OBJECT_CRANK, /* turns on a fixed hinge along the object's z axis; the handle is parallel to the hinge */
    OBJECT_STAND, /* fixed box that a rod can lie on */
} object_kind_t;

typedef enum {
    GRIP_FIXED, /* constrains all six degrees of freedom */
    GRIP_BALL,  /* the object rotates freely in the grip */
} grip_kind_t;

typedef struct {
    scenario_name_t name;
    double along_m; /* position on the axis of a rod or of a crank's handle, from the axis's centre */
} object_point_t;

typedef struct {
    scenario_name_t name;
    object_kind_t kind;
    rigid_pose_t pose;       /* start pose of the centre or, for a crank, of the hinge (handle at +x) */
    double length_m;         /* length of a rod, or of a crank's handle */
    double radius_m;         /* radius of a rod, or distance from a crank's hinge to the axis of its handle */
    double size_m[3];        /* size of a stand */
    double mass_kg;          /* mass of a rod, or of a crank's handle with its arm */
    double damping_Nmspprad; /* crank: viscous friction */
    double friction_Nm;      /* crank: dry friction */
    grip_kind_t robot_grip, person_grip;
    bool held_by_robot; /* rod: starts in the closed gripper */
    object_point_t point[SCENARIO_MAX_POINTS];
    size_t point_count;
} object_t;

#define OBJECT_HANDLE_RADIUS_M 0.01 /* radius of a crank's handle */

/* The robot's gripper: two compliant, padded jaws. The object slips out above a load limit. */
typedef struct {
    double offset_m[3];                    /* centre of the gripper in the frame of the end effector */
    double stroke_s;                       /* time from open to closed */
    double capture_m;                      /* the jaws grip an object if its axis is this close to the centre */
    double stiffness_Npm, damping_Nspm;    /* stiffness and damping of the pads, along each axis */
    double force_limit_N, torque_limit_Nm; /* beyond either limit, the object slips out */
} gripper_t;

/* ---- points that a hand can move to */

typedef enum {
    POINT_NONE,
    POINT_OBJECT,      /* a point of object[index] */
    POINT_PERSON_GRIP, /* the grip point of person[index] */
    POINT_ROBOT_GRIPPER,
} point_kind_t;

typedef struct {
    point_kind_t kind;
    size_t index;
    size_t point; /* index in the object's points */
} point_t;

/* ---- when a step begins */

typedef struct {
    double at_s;                       /* earliest start of the step; 0: no restriction */
    int awaited[SCENARIO_MAX_AWAITED]; /* indices in scenario.events; the step waits for all these events */
    size_t awaited_count;
    double delay_s;    /* delay after the last awaited event, or after the previous step if no event is awaited */
    double patience_s; /* timeout for the awaited events, after which the run fails; 0 for no timeout */
} step_start_t;

/* ---- people */

typedef enum {
    PERSON_REST,  /* holds the hand still for duration_s */
    PERSON_MOVE,  /* minimum-jerk move by displacement_m and rotation_vector_rad (see from_here) */
    PERSON_REACH, /* moves the person's grip point to the point `to` */
    PERSON_GUIDE, /* moves the hand so that the point `what`, which the robot carries, reaches the point `to` */
    PERSON_PLAY,  /* replays the recording from the current pose */
    PERSON_GRIP,  /* closes the hand on the object */
    PERSON_RELEASE,
    PERSON_TURN, /* turns the crank that the hand holds */
} person_action_t;

typedef struct {
    scenario_name_t name; /* the step raises "PERSON.NAME" when it is finished; "" for no event */
    person_action_t action;
    step_start_t start;
    double duration_s;                     /* turn: duration of one revolution; other actions: of the step */
    double displacement_m[3];              /* move: in torso axes */
    double rotation_vector_rad[3];         /* move: in torso axes */
    bool from_here;                        /* move: relative to the end of the last step, not to the start pose */
    point_t what, to;                      /* guide uses both points; reach uses only `to` */
    double offset_m[3];                    /* reach, guide: added to `to` */
    double tolerance_m;                    /* reach, guide: the hand makes corrections until the error is below this */
    double lift_m;                         /* reach, guide: height of the path's arc */
    size_t object;                         /* grip, turn */
    double turns;                          /* turn: signed, about the hinge's axis */
    char recording[SCENARIO_PATH_BYTES];   /* play: path of the file; "": the path on the command line */
    char axes[8];                          /* play: axes of the recorder; "": the file's name determines them */
    double position_scale, rotation_scale; /* play: factors for motion relative to the recording's first pose */
    double from_s, until_s;                /* play: section of the recording; until_s is 0 for its end */
} person_step_t;

#define PERSON_GYRATION_M 0.06

typedef struct {
    scenario_name_t name;
    bool tracked;       /* wears the tracker's marker; exactly one person does */
    rigid_pose_t start; /* start pose of the hand, palm down; its frame has z forward along the forearm and x up */
    double grip_m[3];   /* grip point in the frame of the hand */
    double elbow_m[3];  /* position of the elbow, which does not move */
    double mass_kg; /* effective mass of hand and forearm at the hand; its radius of gyration is PERSON_GYRATION_M */
    double stiffness_Npm, damping_ratio; /* resistance of the arm to forces at the hand */
    double stiffness_Nmprad;             /* stiffness of the wrist */
    double grip_force_limit_N;
    double tremor_mm; /* RMS, all axes combined */
    cup_t cup;
    person_step_t step[SCENARIO_MAX_STEPS];
    size_t step_count;
    person_step_t recorded_step[SCENARIO_MAX_STEPS]; /* used instead of `step` when a recording is given */
    size_t recorded_step_count;
    int done_event; /* "PERSON.done" */
} person_t;

/* ---- the operator */

typedef enum {
    OPERATE_COMMAND, /* start, latch, clutch, stop; select a built-in task */
    OPERATE_DEFINE,  /* select a task that the scenario defines */
    OPERATE_GRIPPER, /* open or close */
} operate_kind_t;

typedef struct {
    scenario_name_t name; /* the step raises "operator.NAME" when it is acknowledged; "" for no event */
    step_start_t start;
    operate_kind_t kind;
    command_t command;
    task_id_t task;  /* the built-in task to select */
    size_t own_task; /* OPERATE_DEFINE */
    bool close;      /* OPERATE_GRIPPER */
} operate_step_t;

typedef struct {
    scenario_name_t name;
    task_define_t define;
} own_task_t;

/* ---- checks, which take the pose of the end effector from ODE */

typedef enum {
    MEASURE_SETTLED_POSITION, /* mm, largest distance between the end effector and the target */
    MEASURE_FOLLOWING_RMS,    /* mm, RMS of the same distance */
    MEASURE_RELATION_RMS,     /* mm, RMS: end effector's motion since `from` minus motion_scale times the hand's */
    MEASURE_DISPLACEMENT, /* mm, end effector displacement from `from` to `until` minus expected_m times motion_scale */
    MEASURE_WAY_X,
    MEASURE_WAY_Y,
    MEASURE_WAY_Z,             /* mm, end effector displacement along this axis from `from` to `until`; signed */
    MEASURE_TILT,              /* deg, smallest tilt of the end effector axis that pointed up at the start */
    MEASURE_CUP_TILT_PEAK,     /* deg, largest angle between torso z and the axis of the robot's cup */
    MEASURE_TURN,              /* deg, end effector rotation from `from` to `until` minus expected_deg */
    MEASURE_WATER_POURED,      /* %, share of all particles that left the robot's cup */
    MEASURE_WATER_CAUGHT,      /* %, share of the poured particles that are in the person's cup at the end */
    MEASURE_FLOW_WHILE_MOVING, /* particles that left while the person's hand moved faster than 5 mm/s */
    MEASURE_DROPS,             /* times the object slipped out of a grip or was dropped after it had been gripped */
    MEASURE_HELD,              /* 1 if only the named person holds the object at the end */
    MEASURE_FORCE_RMS,         /* N, at the person's hand while it holds the object, from ODE's joint */
    MEASURE_FORCE_PEAK,
    MEASURE_TURNS,          /* turns of the crank */
    MEASURE_CARRIED_FOR,    /* s, time for which robot and person held the object together */
    MEASURE_CLEARANCE,      /* mm, smallest distance between person and robot, except for intended contact */
    MEASURE_SELF_CLEARANCE, /* mm, smallest distance between the arm and the rest of the robot */
    MEASURE_AIM,            /* mm, mean end effector position relative to the hand minus expected_m; torso axes */
} measure_t;

/* A time of the run, absolute or relative to an event. */
typedef struct {
    int event; /* `s` counts from this event; EVENT_NONE: from the start of the run */
    double s;
} moment_t;

typedef struct {
    scenario_name_t name;
    measure_t measure;
    moment_t from, until;     /* the window; a measure that takes the last value takes it at `until` */
    bool has_from, has_until; /* false: the default in check_window.h applies */
    double expected_m[3];
    double expected_deg;
    size_t object, person;
    double limit;
    bool is_lower_bound; /* true: the value must be at least the limit; false: at most */
} scenario_check_t;

/* Ranges in which the seed varies a scenario. Each quantity changes by a random amount that is uniformly distributed
 * from minus to plus the value given here. */
typedef struct {
    double start_m;          /* start position of the tracked person's hand, per axis */
    double move_m;           /* end of each move, per axis; moves to the same position get the same shift */
    double object_m[3];      /* position of the objects that the robot does not hold; all get the same shift */
    double duration_percent; /* duration of each step that has a duration */
} variation_t;

typedef struct {
    scenario_name_t name;
    char summary[SCENARIO_TEXT_BYTES];
    char path[SCENARIO_PATH_BYTES];
    double duration_s; /* upper limit; the operator stops the arm at least SCENARIO_STOP_BEFORE_END_S earlier */
    double start_deg[ROBOT_JOINTS];
    bool parameter_written[PARAMETER_COUNT];
    float parameter_value[PARAMETER_COUNT];
    own_task_t own_task[SCENARIO_MAX_TASKS];
    size_t own_task_count;
    gripper_t gripper;
    cup_t cup; /* mounted on the end effector */
    water_t water;
    object_t object[SCENARIO_MAX_OBJECTS];
    size_t object_count;
    person_t person[SCENARIO_MAX_PEOPLE];
    size_t person_count;
    size_t tracked; /* index of the person who wears the tracker's marker */
    operate_step_t operate[SCENARIO_MAX_STEPS];
    size_t operate_count;
    scenario_check_t check[SCENARIO_MAX_CHECKS];
    size_t check_count;
    double tracking_rms_limit_mm, tracking_max_limit_mm; /* 0: not checked */
    double followable_min_percent;                       /* 0: not checked */
    variation_t variation;
    events_t events; /* all events that can happen during a run; no event has happened yet */
} scenario_t;

#define SCENARIO_STOP_BEFORE_END_S 0.5 /* time from the operator's stop to the end of the run */

/* Varies the start position, the moves, the objects' positions and the durations at random, within the ranges of
 * `variation`. The seed determines the variation; seed 0 changes nothing. */
void scenario_vary(scenario_t *self, uint64_t seed);

#endif
