"""File formats of robots, each with its reader and its writer in one folder."""
