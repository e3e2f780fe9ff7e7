"""Joints of a design between its links."""
