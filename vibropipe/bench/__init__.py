"""How fast this is, measured side by side with peers in one run: `vibropipe bench`."""
