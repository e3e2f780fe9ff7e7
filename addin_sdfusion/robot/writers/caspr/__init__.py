"""CASPR's XML files."""
