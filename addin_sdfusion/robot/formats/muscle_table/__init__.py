"""The table of muscles next to a robot file, muscles.csv, and its contents as plain data."""
