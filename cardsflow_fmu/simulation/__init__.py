"""Build and run an experiment."""
