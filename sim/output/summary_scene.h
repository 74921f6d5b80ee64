/* The parts of summary.json about the physical scene, and about what was played and which law was in force. */
#ifndef COMANIP_SIM_SUMMARY_SCENE_H
#define COMANIP_SIM_SUMMARY_SCENE_H

#include "../world/world.h"
#include "json_writer.h"

/* "recording", "second_recording", "law". */
void summary_write_setting(json_writer_t *json, const world_t *world);

/* "people", "gripper", "clearance", "water", "events". */
void summary_write_scene(json_writer_t *json, const world_t *world);

#endif
