"""The quadratic program over muscle forces."""
