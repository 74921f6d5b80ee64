"""The firmware as images for microcontrollers: size, stack, and a processor in the loop."""
