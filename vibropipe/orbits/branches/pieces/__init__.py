"""Branches of orbits with soft supports or friction: fixed points of the return map, at any sequence of pieces."""
