"""Execution of studies: executors, run store, optimisers."""
