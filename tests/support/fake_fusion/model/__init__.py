"""Model of a design: components, bodies, joints, points."""
