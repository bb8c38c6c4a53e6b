"""Kinds of scenes: a folder for each, bound in one record that the registry knows."""
