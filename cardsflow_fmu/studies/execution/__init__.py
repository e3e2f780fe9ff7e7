"""Execution of studies: executors, run store and optimisers."""
