/* Reads the sections `arm`, `parameters`, `robot` and `water` of a scenario file. */
#include "scenario_sections.h"

#define PARTICLES_MAX 500

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
    yaml_check_keys(yaml, map, keys);
    yaml_need_number(yaml, map, "radius_m", 0.005, 0.5, &cup->radius_m);
    yaml_need_number(yaml, map, "height_m", 0.005, 0.5, &cup->height_m);
    yaml_get_number(yaml, map, "wall_m", 0.0005, 0.02, &cup->wall_m);
    yaml_get_vector(yaml, map, "mount_m", 3, -1.0, 1.0, cup->mount.position_m);
    yaml_get_rotation(yaml, map, "mount_rotation", cup->mount.rotation);
}

static void read_arm(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const keys[] = {"model", "start_deg", NULL};
    static const char *const models[] = {"hoap3_right", NULL};
    yaml_node_t *arm = yaml_need(yaml, yaml_root(yaml), "arm");
    yaml_check_keys(yaml, arm, keys);
    const yaml_node_t *model = yaml_find(yaml, arm, "model");
    if (model != NULL) {
        (void)yaml_word(yaml, model, models);
    }
    yaml_need_vector(yaml, arm, "start_deg", ROBOT_JOINTS, -360.0, 360.0, self->start_deg);
    yaml_node_t *start = yaml_find(yaml, arm, "start_deg");
    for (int i = 0; i < ROBOT_JOINTS && !yaml->failed; i++) {
        const double minimum_deg = robot_model_position_min_rad(i) / ROBOT_RAD_PER_DEG;
        const double maximum_deg = robot_model_position_max_rad(i) / ROBOT_RAD_PER_DEG;
        if (!(self->start_deg[i] >= minimum_deg && self->start_deg[i] <= maximum_deg)) {
            yaml_refuse(yaml, yaml_item(yaml, start, (size_t)i), "a joint position from %g to %g degrees", minimum_deg,
                        maximum_deg);
        }
    }
}

static void read_parameters(yaml_reader_t *yaml, scenario_t *self) {
    yaml_node_t *parameters = yaml_find(yaml, yaml_root(yaml), "parameters");
    const char *names[PARAMETER_COUNT + 1] = {NULL};
    for (int i = 0, count = 0; i < PARAMETER_COUNT; i++) {
        if (parameter_table[i].name != NULL) { /* NULL: an unused parameter number */
            names[count++] = parameter_table[i].name;
        }
    }
    yaml_check_keys(yaml, parameters, names);
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        const parameter_description_t *p = &parameter_table[i];
        const yaml_node_t *node = p->name == NULL ? NULL : yaml_find(yaml, parameters, p->name);
        if (node == NULL) {
            continue;
        }
        self->parameter_written[i] = true;
        self->parameter_value[i] = p->integer
                                       ? (float)yaml_whole_number(yaml, node, (int)p->minimum, (int)p->maximum)
                                       : (float)yaml_number(yaml, node, NULL, (double)p->minimum, (double)p->maximum);
    }
}

static void read_gripper(yaml_reader_t *yaml, yaml_node_t *map, gripper_t *gripper) {
    static const char *const keys[] = {"offset_m",     "stroke_s",      "capture_m",       "stiffness_Npm",
                                       "damping_Nspm", "force_limit_N", "torque_limit_Nm", NULL};
    *gripper = (gripper_t){.stroke_s = 0.3,
                           .capture_m = 0.012,
                           .stiffness_Npm = 3000.0,
                           .damping_Nspm = 20.0,
                           .force_limit_N = 25.0,
                           .torque_limit_Nm = 1.5};
    yaml_check_keys(yaml, map, keys);
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
    self->water = (water_t){.particle_radius_m = 0.005, .density_kgpm3 = 1000.0};
    yaml_check_keys(yaml, map, keys);
    const yaml_node_t *particles = yaml_need(yaml, map, "particles");
    if (particles != NULL) {
        self->water.particles = yaml_whole_number(yaml, particles, 1, PARTICLES_MAX);
    }
    yaml_get_number(yaml, map, "particle_radius_m", 0.001, 0.05, &self->water.particle_radius_m);
    yaml_get_number(yaml, map, "density_kgpm3", 10.0, 20000.0, &self->water.density_kgpm3);
    if (!self->cup.present) {
        yaml_refuse(yaml, map, "a cup that holds it: robot: {cup: ...}");
    }
}

void scenario_read_robot(yaml_reader_t *yaml, scenario_t *self) {
    static const char *const keys[] = {"gripper", "cup", NULL};
    read_arm(yaml, self);
    read_parameters(yaml, self);
    yaml_node_t *robot = yaml_find(yaml, yaml_root(yaml), "robot");
    yaml_check_keys(yaml, robot, keys);
    read_gripper(yaml, yaml_find(yaml, robot, "gripper"), &self->gripper);
    scenario_read_cup(yaml, yaml_find(yaml, robot, "cup"), &self->cup);
    read_water(yaml, self);
}
