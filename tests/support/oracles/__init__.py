"""Independent implementations as references for tests."""
