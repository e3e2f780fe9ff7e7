"""Systems of FMUs as .ssp files: reader, writer, description."""
