/* Presents hubs as CAN interfaces. Each hub's name has an interface index, which is valid only within this process. */
#ifndef COMANIP_SHIM_INTERFACE_NAMES_H
#define COMANIP_SHIM_INTERFACE_NAMES_H

/* Returns the index of the hub with this name, or 0 if there is none. */
unsigned interface_index(const char *name);

/* Returns the name of the hub with this index, or NULL if there is none. */
const char *interface_name(unsigned index);

/* Returns the index of the only hub, or 0 if there is none or more than one. */
unsigned interface_only(void);

#endif
