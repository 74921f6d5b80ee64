/* Writes the parts of summary.json about the physical scene, the recordings and the control law. */
#ifndef COMANIP_SIM_SUMMARY_SCENE_H
#define COMANIP_SIM_SUMMARY_SCENE_H

#include "../world/world.h"
#include "json_writer.h"

/* Writes "recording", "second_recording" and "law". */
void summary_write_setting(json_writer_t *json, const world_t *world);

/* Writes "people", "gripper", "clearance", "water", "events", "object" and "cups". */
void summary_write_scene(json_writer_t *json, const world_t *world);

#endif
