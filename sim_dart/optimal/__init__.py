"""Intervals of motions with exact derivatives, for optimal control."""
