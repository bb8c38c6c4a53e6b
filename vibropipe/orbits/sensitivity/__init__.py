"""Derivatives of orbits and of their outputs by the parameters."""
