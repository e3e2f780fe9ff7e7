"""Plant: mechanism, integrators and energy balance."""
