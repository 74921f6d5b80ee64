#include "help.h"

#include <stdio.h>

#include "../firmware/parameters.h"
#include "scenario.h"

static const char usage[] =
    "comanip-sim: a human hand moves a simulated humanoid arm over a CAN FD bus, in virtual time\n"
    "\n"
    "usage: comanip-sim [options]\n"
    "\n"
    "what runs\n"
    "  --scenario NAME              pour (default), teleop or mirror; --list explains them\n"
    "  --tracker FILE.csv           play a recording instead of the scenario's built-in motion\n"
    "  --axes MAP                   recorder axes that are the torso's x, y, z (forward, left, up), e.g. -yxz\n"
    "  --duration S                 simulated seconds, at least 2 (default: the scenario's, or the recording's)\n"
    "  --seed N                     of noise and dropouts (default 1)\n"
    "  --scale S                    motion scale: sets the parameter motion_scale\n"
    "  --param NAME=VALUE           write a firmware parameter over the bus at the start; repeatable\n"
    "tracker\n"
    "  --rate HZ                    of poses on the bus, 15 to 1000 (default 250)\n"
    "  --noise-mm X, --noise-deg X  standard deviation per axis (default 0.05 and 0.02)\n"
    "  --latency-ms X               from the measurement to the frame (default 4)\n"
    "  --mount-translation X,Y,Z    of the tracker seen from the torso [m] (default 0.3,1.5,0.2)\n"
    "  --mount-rotation W,X,Y,Z     the same (default 0.7071,0.7071,0,0: on the robot's left)\n"
    "  --dropout P                  probability that a sample is lost (default 0)\n"
    "  --gap START:DURATION         one gap [s] without poses\n"
    "  --tracker-clock US           its own clock at the start, e.g. 4294000000 wraps after 1 s (default 0)\n"
    "output\n"
    "  --out DIR                    gets summary.json, bus.log (candump -L) and trace.csv (default out)\n"
    "  --quiet                      no progress and no table, only what went wrong\n"
    "  --list                       the scenarios\n"
    "  --help                       this text\n"
    "\n"
    "examples\n"
    "  comanip-sim --scenario mirror --out /tmp/mirror\n"
    "  comanip-sim --scenario teleop --tracker hand.csv --scale 0.3\n"
    "  comanip-sim --scenario pour --gap 5:0.2 --dropout 0.05 --seed 7\n"
    "  comanip-sim --scenario mirror --param error_frame=0   # the paper's law to the letter\n"
    "\n"
    "exit status: 0 all checks passed, 1 a check failed, 2 wrong use, 130 interrupted\n"
    "\n"
    "parameters (range, default)\n";

void help_print(void) {
    (void)fputs(usage, stdout);
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        const parameter_description_t *p = &parameter_table[i];
        (void)printf("  %-32s %g to %g, %g\n", p->name, (double)p->minimum, (double)p->maximum,
                     (double)p->default_value);
    }
}

void help_print_scenarios(void) {
    for (size_t i = 0; i < scenario_count; i++) {
        (void)printf("%-8s %2.0f s  %s\n", scenario_table[i].name, scenario_table[i].duration_s,
                     scenario_table[i].summary);
    }
}
