"""How the functions inside kernels are compiled.

Only kernels are called from Python. The functions in them need no entry from there, and without one numba makes no
machine code of each by itself: a tenth of the compilation of a material law.
"""

INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
POINT = INNER | {"forceinline": True}  # of one point: without it elastic updates run at half the speed
# Of passes over blocks of points. A product and a sum round once, where the machine can: a fifth off the return map.
# Blocks lie at fixed places, so that the bits do not depend on the number of threads; nothing else of `fastmath` is on.
FUSED = INNER | {"fastmath": {"contract"}}
FUSED_POINT = FUSED | {"forceinline": True}
