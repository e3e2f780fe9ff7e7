"""Muscle table: rows, edits, and storage in designs and CSV files."""
