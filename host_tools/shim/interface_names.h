/* CAN interfaces that are hubs. Each hub's name has an interface index, which is valid within this process. */
#ifndef COMANIP_SHIM_INTERFACE_NAMES_H
#define COMANIP_SHIM_INTERFACE_NAMES_H

/* The index of the hub with this name, 0 if there is none. */
unsigned interface_index(const char *name);

/* The name of the hub with this index, NULL if there is none. */
const char *interface_name(unsigned index);

/* The index of the only hub, 0 if there is none or several. */
unsigned interface_only(void);

#endif
