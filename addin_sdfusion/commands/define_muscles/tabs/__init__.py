"""Tabs of the dialog: their inputs, and how they show the model."""
