"""Reader of CASPR's XML files."""
