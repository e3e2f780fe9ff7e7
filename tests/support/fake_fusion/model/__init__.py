"""The model of a design: components, bodies, joints, points."""
