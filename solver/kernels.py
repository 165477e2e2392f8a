"""How the functions inside kernels are compiled.

Only kernels are called from Python. The functions in them need no entry from there, and without one numba makes no
machine code of each by itself: a tenth of the compilation of a material law.
"""

INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
POINT = INNER | {"forceinline": True}  # of one point: without it elastic updates run at half the speed
