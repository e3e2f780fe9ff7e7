"""Definition of studies: variations, sampling, metrics."""
