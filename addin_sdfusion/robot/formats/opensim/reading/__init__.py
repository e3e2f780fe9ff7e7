"""Parts of the reader of OpenSim models."""
