/* What comanip-sim says about itself. */
#ifndef COMANIP_SIM_HELP_H
#define COMANIP_SIM_HELP_H

void help_print(void);
void help_print_scenarios(void);

#endif
