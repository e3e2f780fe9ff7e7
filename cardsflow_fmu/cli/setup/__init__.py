"""Commands that create experiments, schemas and completions, and install the add-in."""
