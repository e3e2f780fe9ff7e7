"""Muscle paths and muscle laws."""
