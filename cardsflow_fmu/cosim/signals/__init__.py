"""Variables of FMUs: names, units, types and order."""
