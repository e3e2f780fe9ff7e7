"""The XML format of CASPR."""
