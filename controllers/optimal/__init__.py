"""Optimal motions: multiple shooting, solved by sequential quadratic programming."""
