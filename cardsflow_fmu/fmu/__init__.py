"""FMU files: model descriptions, terminals, binaries, sources."""
