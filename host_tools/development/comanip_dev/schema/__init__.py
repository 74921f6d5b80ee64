"""From the schema, firmware/schema/, to C and to documents."""
