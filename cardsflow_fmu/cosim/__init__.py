"""Fixed-step co-simulation: master, wiring, FMU instances."""
