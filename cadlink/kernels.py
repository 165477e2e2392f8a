"""How the point functions of a projection are compiled.

Nothing is allocated inside them, so they need no reference counts, which cost 5 ns for each array of each call and
are half of a tracked point's time; a division by zero is infinity, tested where it matters, not at each division; and a
product and a sum round once, where the machine can, which takes a fifth off a search.
"""

POINT = {"_nrt": False, "error_model": "numpy", "fastmath": {"contract"}}
# Those that take the whole skin have no entry from Python: saves a quarter of the compilation.
INNER = POINT | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
