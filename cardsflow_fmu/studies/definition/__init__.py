"""Definition of studies: variations, sampling and metrics."""
