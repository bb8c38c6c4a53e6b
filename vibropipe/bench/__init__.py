"""Benchmark against reference packages, all timed in the same rounds: `vibropipe bench`."""
