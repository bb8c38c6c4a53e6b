"""Kinds of scenes: one folder each, and a registry of all kinds."""
