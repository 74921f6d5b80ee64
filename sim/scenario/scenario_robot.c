/* Sections arm, parameters, robot, water, tasks and objects. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "scenario_sections.h"

#define POSE_KEYS "position_m", "rotation"

void scenario_read_pose(yaml_reader_t *yaml, yaml_node_t *map, rigid_pose_t *pose) {
    yaml_get_vector(yaml, map, "position_m", 3, -FAR_M, FAR_M, pose->position_m);
    pose->rotation[0] = 1.0;
    yaml_get_rotation(yaml, map, "rotation", pose->rotation);
}

void scenario_read_cup(yaml_reader_t *yaml, yaml_node_t *map, cup_t *cup) {
    static const char *const keys[] = {"radius_m", "height_m", "wall_m", "mount_m", "mount_rotation", NULL};
    if (map == NULL) {
        return;
    }
    cup->present = true;
    cup->wall_m = 0.002;
    cup->mount.rotation[0] = 1.0;
    yaml_check_keys(yaml, map, "cup", keys);
    (void)yaml_need(yaml, map, "cup", "radius_m");
    (void)yaml_need(yaml, map, "cup", "height_m");
    yaml_get_number(yaml, map, "radius_m", 0.005, 0.5, &cup->radius_m);
    yaml_get_number(yaml, map, "height_m", 0.005, 0.5, &cup->height_m);
    yaml_get_number(yaml, map, "wall_m", 0.0005, 0.02, &cup->wall_m);
    yaml_get_vector(yaml, map, "mount_m", 3, -1.0, 1.0, cup->mount.position_m);
    yaml_get_rotation(yaml, map, "mount_rotation", cup->mount.rotation);
}

static void read_parameters(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *parameters = yaml_find(yaml, yaml_root(yaml), "parameters");
    const char *names[PARAMETER_COUNT + 1] = {NULL};
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        names[i] = parameter_table[i].name;
    }
    yaml_check_keys(yaml, parameters, "parameters", names);
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        const parameter_description_t *p = &parameter_table[i];
        yaml_node_t *node = yaml_find(yaml, parameters, p->name);
        if (node == NULL) {
            continue;
        }
        const double value = yaml_number(yaml, node, p->name, (double)p->minimum, (double)p->maximum);
        if (p->integer && value != floor(value)) {
            yaml_refuse(yaml, node, p->name, "a whole number");
        }
        self->parameter_written[i] = true;
        self->parameter_value[i] = (float)value;
    }
}

static void read_gripper(yaml_reader_t *yaml, yaml_node_t *map, gripper_t *gripper) {
    static const char *const keys[] = {"offset_m", "stroke_s", "capture_m", "stiffness_Npm", "damping_Nspm",
                                       "force_limit_N", "torque_limit_Nm", NULL};
    *gripper = (gripper_t){.stroke_s = 0.3, .capture_m = 0.012, .stiffness_Npm = 3000.0, .damping_Nspm = 20.0,
                           .force_limit_N = 25.0, .torque_limit_Nm = 1.5};
    yaml_check_keys(yaml, map, "gripper", keys);
    yaml_get_vector(yaml, map, "offset_m", 3, -0.5, 0.5, gripper->offset_m);
    yaml_get_number(yaml, map, "stroke_s", 0.01, 10.0, &gripper->stroke_s);
    yaml_get_number(yaml, map, "capture_m", 0.0001, 0.1, &gripper->capture_m);
    yaml_get_number(yaml, map, "stiffness_Npm", 10.0, 1e6, &gripper->stiffness_Npm);
    yaml_get_number(yaml, map, "damping_Nspm", 0.0, 1e4, &gripper->damping_Nspm);
    yaml_get_number(yaml, map, "force_limit_N", 0.01, 1e4, &gripper->force_limit_N);
    yaml_get_number(yaml, map, "torque_limit_Nm", 0.001, 1e3, &gripper->torque_limit_Nm);
}

static void read_water(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const keys[] = {"particles", "particle_radius_m", "density_kgpm3", NULL};
    yaml_node_t *map = yaml_find(yaml, yaml_root(yaml), "water");
    if (map == NULL) {
        return;
    }
    double particles = 0.0;
    self->water = (water_t){.particle_radius_m = 0.005, .density_kgpm3 = 1000.0};
    yaml_check_keys(yaml, map, "water", keys);
    (void)yaml_need(yaml, map, "water", "particles");
    yaml_get_number(yaml, map, "particles", 1.0, 500.0, &particles);
    yaml_get_number(yaml, map, "particle_radius_m", 0.001, 0.05, &self->water.particle_radius_m);
    yaml_get_number(yaml, map, "density_kgpm3", 10.0, 20000.0, &self->water.density_kgpm3);
    if (particles != floor(particles)) {
        yaml_refuse(yaml, yaml_find(yaml, map, "particles"), "particles", "a whole number");
    }
    self->water.particles = (int)particles;
    if (!self->cup.present) {
        yaml_refuse(yaml, map, "water", "a cup that holds it: robot: {cup: ...}");
    }
}

void scenario_read_robot(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const arm_keys[] = {"model", "start_deg", NULL};
    static const char *const models[] = {"hoap3_right", NULL};
    static const char *const robot_keys[] = {"gripper", "cup", NULL};
    yaml_node_t *root = yaml_root(yaml);
    yaml_node_t *arm = yaml_need(yaml, root, "scenario", "arm");
    yaml_check_keys(yaml, arm, "arm", arm_keys);
    if (yaml_find(yaml, arm, "model") != NULL) {
        (void)yaml_word(yaml, yaml_find(yaml, arm, "model"), "model", models);
    }
    (void)yaml_need(yaml, arm, "arm", "start_deg");
    yaml_get_vector(yaml, arm, "start_deg", ROBOT_JOINTS, -360.0, 360.0, self->start_deg);
    read_parameters(yaml, self);
    yaml_node_t *robot = yaml_find(yaml, root, "robot");
    yaml_check_keys(yaml, robot, "robot", robot_keys);
    read_gripper(yaml, yaml_find(yaml, robot, "gripper"), &self->gripper);
    scenario_read_cup(yaml, yaml_find(yaml, robot, "cup"), &self->cup);
    read_water(yaml, self);
}

/* ---- tasks */

static void read_task(yaml_reader_t *yaml, yaml_node_t *map, task_define_t *define) {
    static const char *const keys[] = {"form", "t_task_m", "q_task", "q_inv", "blend_s", NULL};
    static const char *const forms[] = {"constant", "mirrored", NULL};
    double t_task_m[3] = {0.0, 0.0, 0.0}, blend_s = 1.0;
    double q_task[4] = {1.0, 0.0, 0.0, 0.0}, q_inv[4] = {1.0, 0.0, 0.0, 0.0};
    yaml_check_keys(yaml, map, "task", keys);
    const int form = yaml_word(yaml, yaml_need(yaml, map, "task", "form"), "form", forms);
    yaml_get_vector(yaml, map, "t_task_m", 3, -8.0, 8.0, t_task_m);
    yaml_get_rotation(yaml, map, "q_task", q_task);
    yaml_get_rotation(yaml, map, "q_inv", q_inv);
    yaml_get_number(yaml, map, "blend_s", 0.0, 65.0, &blend_s);
    define->form = (uint8_t)(form == 1 ? TASK_FORM_MIRRORED : TASK_FORM_CONSTANT);
    define->t_task_m = (vector3_t){(float)t_task_m[0], (float)t_task_m[1], (float)t_task_m[2]};
    define->q_task = (quaternion_t){(float)q_task[0], (float)q_task[1], (float)q_task[2], (float)q_task[3]};
    define->q_inv = (quaternion_t){(float)q_inv[0], (float)q_inv[1], (float)q_inv[2], (float)q_inv[3]};
    define->blend_s = (float)blend_s;
}

void scenario_read_tasks(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *tasks = yaml_find(yaml, yaml_root(yaml), "tasks");
    const char *name;
    yaml_node_t *name_node, *task;
    if (tasks != NULL && !yaml_is_mapping(tasks)) {
        yaml_refuse(yaml, tasks, "tasks", "a mapping of names to tasks");
    }
    for (size_t i = 0; yaml_entry(yaml, tasks, i, &name, &name_node, &task); i++) {
        if (self->own_task_count == SCENARIO_MAX_TASKS) {
            yaml_refuse(yaml, name_node, "tasks", "at most 8 tasks");
            return;
        }
        own_task_t *own = &self->own_task[self->own_task_count++];
        yaml_copy_name(yaml, name_node, name, own->name, sizeof own->name);
        if (strcmp(name, "pour") == 0 || strcmp(name, "teleop") == 0 || strcmp(name, "mirror") == 0) {
            yaml_refuse(yaml, name_node, "tasks", "another name: pour, teleop and mirror are built in");
        }
        read_task(yaml, task, &own->define);
    }
}

/* ---- objects */

static void read_held(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const holders[] = {"robot", NULL};
    static const char *const grips[] = {"fixed", "ball", NULL};
    const yaml_node_t *held = yaml_find(yaml, map, "held_by");
    const yaml_node_t *robot = yaml_find(yaml, map, "robot_grip"), *person = yaml_find(yaml, map, "person_grip");
    object->held_by_robot = held != NULL && yaml_word(yaml, held, "held_by", holders) == 0;
    object->robot_grip = robot != NULL && yaml_word(yaml, robot, "robot_grip", grips) == 1 ? GRIP_BALL : GRIP_FIXED;
    object->person_grip =
        person != NULL && yaml_word(yaml, person, "person_grip", grips) == 1 ? GRIP_BALL : GRIP_FIXED;
}

static void read_rod(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const keys[] = {"kind", POSE_KEYS, "length_m", "radius_m", "mass_kg", "robot_grip",
                                       "person_grip", "held_by", "points", NULL};
    static const char *const needed[] = {"length_m", "radius_m", "mass_kg"};
    yaml_check_keys(yaml, map, object->name, keys);
    for (size_t i = 0; i < 3; i++) {
        (void)yaml_need(yaml, map, object->name, needed[i]);
    }
    read_held(yaml, map, object);
}

static void read_crank(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const keys[] = {"kind", POSE_KEYS, "length_m", "radius_m", "mass_kg", "robot_grip",
                                       "person_grip", "damping_Nmspprad", "friction_Nm", "points", NULL};
    static const char *const needed[] = {"length_m", "radius_m", "mass_kg"};
    yaml_check_keys(yaml, map, object->name, keys);
    for (size_t i = 0; i < 3; i++) {
        (void)yaml_need(yaml, map, object->name, needed[i]);
    }
    yaml_get_number(yaml, map, "damping_Nmspprad", 0.0, 100.0, &object->damping_Nmspprad);
    yaml_get_number(yaml, map, "friction_Nm", 0.0, 100.0, &object->friction_Nm);
    read_held(yaml, map, object);
}

static void read_stand(yaml_reader_t *yaml, yaml_node_t *map, object_t *object) {
    static const char *const keys[] = {"kind", POSE_KEYS, "size_m", NULL};
    yaml_check_keys(yaml, map, object->name, keys);
    (void)yaml_need(yaml, map, object->name, "size_m");
    yaml_get_vector(yaml, map, "size_m", 3, 0.001, FAR_M, object->size_m);
}

void scenario_read_objects(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const kinds[] = {"rod", "crank", "stand", NULL};
    yaml_node_t *objects = yaml_find(yaml, yaml_root(yaml), "objects");
    for (size_t i = 0; i < self->object_count; i++) {
        object_t *object = &self->object[i];
        yaml_node_t *map = yaml_find(yaml, objects, object->name);
        const int kind = yaml_word(yaml, yaml_need(yaml, map, object->name, "kind"), "kind", kinds);
        object->kind = kind == 1 ? OBJECT_CRANK : kind == 2 ? OBJECT_STAND : OBJECT_ROD;
        (void)yaml_need(yaml, map, object->name, "position_m");
        scenario_read_pose(yaml, map, &object->pose);
        yaml_get_number(yaml, map, "length_m", 0.01, FAR_M, &object->length_m);
        yaml_get_number(yaml, map, "radius_m", 0.001, 1.0, &object->radius_m);
        yaml_get_number(yaml, map, "mass_kg", 0.001, 20.0, &object->mass_kg);
        if (object->kind == OBJECT_ROD) {
            read_rod(yaml, map, object);
        } else if (object->kind == OBJECT_CRANK) {
            read_crank(yaml, map, object);
        } else {
            read_stand(yaml, map, object);
        }
    }
}
