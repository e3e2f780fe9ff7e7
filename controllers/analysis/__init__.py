"""Analyses of robot and controller: gains, linearisation, workspaces, sizing."""
