"""Robots made from robots: simplified, combined, repaired."""
