"""Branches of orbits: impact sequences, continuation, bifurcations, and switching between branches."""
