"""Models inside the FMUs. They also run without FMI."""
