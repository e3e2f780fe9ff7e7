"""Dynamics for controllers."""
