"""Tables, statistics and figures of studies."""
