"""Muscles over a whole given motion: activation dynamics and elastic tendons."""
