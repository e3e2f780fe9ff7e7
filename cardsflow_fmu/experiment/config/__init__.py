"""TOML files: key paths, tables, error messages."""
