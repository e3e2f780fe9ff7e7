"""Parts of `fusion_design`, the reader of the open design."""
