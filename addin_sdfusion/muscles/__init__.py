"""The table of muscles: its rows, its edits, and how the design and CSV files hold it."""
