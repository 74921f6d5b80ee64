/* The firmware's entry point, called by a target's reset handler or by the simulator. */
#ifndef COMANIP_MAIN_H
#define COMANIP_MAIN_H

/* Returns only when hal_wait_tick() reports that the platform is shutting down. */
void firmware_main(void);

#endif
