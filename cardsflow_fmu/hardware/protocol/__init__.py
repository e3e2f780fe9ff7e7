"""Hardware protocol: frames, handshake, signatures and recordings."""
