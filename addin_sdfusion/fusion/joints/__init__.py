"""Joints and rigid groups of a Fusion design, in the root frame."""
