"""Reader of the open Fusion design: `design.read_design` gives its snapshot."""
