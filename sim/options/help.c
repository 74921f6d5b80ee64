#include "help.h"

#include <stdio.h>
#include <string.h>

#include "../scenario/scenario_file.h"
#include "comanip_parameters.h"

static const char usage[] =
    "comanip-sim: a human hand moves a simulated humanoid arm over a CAN bus, in virtual time\n"
    "\n"
    "usage: build/host/comanip-sim [options]\n"
    "       make sim ARGS='[options]'   (make exits with 2 on any failure, the program as stated below)\n"
    "\n"
    "what runs\n"
    "  --scenario NAME|FILE.yaml    pour (default), teleop, mirror, handover or crank, or the path of a file\n"
    "  --tracker FILE.csv           the tracked person plays a recording instead of the built-in motion\n"
    "  --tracker-second FILE.csv    the second person plays a recording\n"
    "  --axes MAP                   the recorder's axes that point along the torso's x, y, z (forward, left,\n"
    "                               up), e.g. -yxz\n"
    "  --duration S                 simulated seconds, at least 2 (default: until all scripts have ended)\n"
    "  --physics-step-us N          step of the physics: 500, 1000 (default) or 2000\n"
    "  --seed N                     seed of noise, dropouts, motion and object positions (default 1)\n"
    "  --scale S                    motion scale: sets the parameter motion_scale\n"
    "  --param NAME=VALUE           write a firmware parameter over the bus at the start; repeatable\n"
    "  --paper-law                  equation (4) of the paper as control law: sets prediction 0, error_frame 0,\n"
    "                               all weights 1, all gains 4; --param overrides these values\n"
    "  --define FORM:TX,TY,TZ:QW,QX,QY,QZ:IW,IX,IY,IZ:BLEND\n"
    "                               the operator selects this task in place of the scenario's: FORM is constant\n"
    "                               or mirrored; then t_task [m], q_task, q_inv and the blend time [s]\n"
    "  --clutch S                   at S seconds, the operator sends the command clutch (sets a new reference)\n"
    "tracker\n"
    "  --rate HZ                    rate of poses on the bus, 15 to 1000 (default 250; classic CAN 125)\n"
    "  --noise-mm X, --noise-deg X  standard deviation of the noise per axis (default 0.05 and 0.02)\n"
    "  --latency-ms X               time from a measurement to its frame (default 4)\n"
    "  --mount-translation X,Y,Z    position of the tracker in torso axes [m] (default 0.3,1.5,0.2)\n"
    "  --mount-rotation W,X,Y,Z     orientation of the tracker (default 0.7071,0.7071,0,0: on the robot's left);\n"
    "                               give the firmware the inverse rotation as a rotation vector:\n"
    "                               --param tracker_rotation_x_rad=..., likewise _y_ and _z_\n"
    "  --dropout P                  probability that a sample is lost (default 0)\n"
    "  --gap START:DURATION         one gap [s] without poses\n"
    "  --tracker-clock US           the tracker's clock at the start [us]; 4294000000 overflows after 1 s (default 0)\n"
    "bus\n"
    "  --profile fd|classic         CAN FD, control at 1 kHz (default), or classic CAN, at 250 Hz\n"
    "  --hub NAME                   publish each frame on the hub NAME, e.g. vcan0, as soon as it is sent;\n"
    "                               starts a hub if none runs\n"
    "  --real-time                  run no faster than real time\n"
    "output\n"
    "  --out DIR                    folder for summary.json, bus.log (candump -L), trace.csv (default out/SCENARIO)\n"
    "  --quiet                      print only errors, no progress and no table\n"
    "  --list                       list the scenarios\n"
    "  -h, --help                   show this text\n"
    "\n"
    "examples\n"
    "  build/host/comanip-sim --scenario mirror --out /tmp/mirror\n"
    "  build/host/comanip-sim --scenario teleop --tracker hand.csv --scale 0.2\n"
    "  build/host/comanip-sim --scenario pour --gap 5:0.2 --dropout 0.05 --seed 7\n"
    "  build/host/comanip-sim --scenario mirror --paper-law\n"
    "  build/host/comanip-sim --define constant:0,0,0.1:1,0,0,0:1,0,0,0:1 --clutch 5\n"
    "\n"
    "exit status: 0 all checks passed, 1 a check failed, 2 usage error, 130 interrupted\n"
    "\n"
    "parameters (range, default)\n";

typedef struct {
    const char *name, *unit, *group, *meaning;
    float minimum, maximum, default_value;
} parameter_help_t;

#define ROW(number, name, minimum, maximum, default_value, integer, unit, group, meaning)                              \
    {name, unit, group, meaning, minimum, maximum, default_value},
static const parameter_help_t parameters[] = {COMANIP_PARAMETERS(ROW)};

void help_print(void) {
    (void)fputs(usage, stdout);
    for (size_t i = 0; i < sizeof parameters / sizeof parameters[0]; i++) {
        const parameter_help_t *p = &parameters[i];
        if (i == 0 || strcmp(p->group, parameters[i - 1].group) != 0) {
            (void)printf("  %s\n", p->group);
        }
        /* The elements of a vector have the same meaning, which is printed only before the first element. */
        if (i == 0 || strcmp(p->meaning, parameters[i - 1].meaning) != 0) {
            (void)printf("    %s\n", p->meaning);
        }
        (void)printf("      %-32s %g to %g%s%s, %g\n", p->name, (double)p->minimum, (double)p->maximum,
                     p->unit[0] != '\0' ? " " : "", p->unit, (double)p->default_value);
    }
}

static void print_scenario(void *context, const char *name, const char *summary) {
    (void)context;
    (void)printf("%-10s %s\n", name, summary);
}

bool help_print_scenarios(const char *folder, char error[], size_t error_size) {
    return scenario_list(folder, print_scenario, NULL, error, error_size);
}
