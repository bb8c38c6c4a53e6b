"""The compiler: flags of numba, the hash of sources, the cache of kernels, and the process that compiles.

Kernels take their decorator from `flags`; `sources` finds the code that stored numbers depend on.
"""

from vibropipe.compiler.flags import (
    jit,
    jit_allocating,
    jit_inline,
    jit_nogil,
    jit_parallel,
)
from vibropipe.compiler.sources import kernel_hash

__all__ = [
    "jit",
    "jit_allocating",
    "jit_inline",
    "jit_nogil",
    "jit_parallel",
    "kernel_hash",
]
