"""The hardware protocol: frames, handshake, signatures, recordings."""
