"""Tools for the images for microcontrollers: size, stack, and processor in the loop."""
