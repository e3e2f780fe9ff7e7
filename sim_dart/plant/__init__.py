"""The plant: mechanism, integrators, energy."""
