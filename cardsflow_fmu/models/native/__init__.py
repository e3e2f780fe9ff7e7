"""Library, files and variables of models in C."""
