"""Output to terminals and pipes: safe streams, colours, messages, progress."""
