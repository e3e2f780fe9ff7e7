"""Reader for the open Fusion design: `design.read_design` returns its snapshot."""
