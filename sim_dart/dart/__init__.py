"""DART: skeletons, worlds, contacts."""
