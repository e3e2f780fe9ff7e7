"""Systems of FMUs as .ssp files: reader, writer, run."""
