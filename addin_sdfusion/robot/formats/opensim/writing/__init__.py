"""Parts of the writer of OpenSim models."""
