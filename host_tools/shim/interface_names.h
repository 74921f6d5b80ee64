/* CAN interfaces that are hubs: a hub's name gets an index, which holds within this process. */
#ifndef COMANIP_SHIM_INTERFACE_NAMES_H
#define COMANIP_SHIM_INTERFACE_NAMES_H

/* 0 if no hub of this name is there. */
unsigned interface_index(const char *name);

/* NULL if no interface has this index. */
const char *interface_name(unsigned index);

/* The only hub there is. 0 if there is none, or several. */
unsigned interface_only(void);

#endif
