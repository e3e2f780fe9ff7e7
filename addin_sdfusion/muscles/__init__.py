"""Table of muscles: rows, edits, and its forms in designs and CSV files."""
