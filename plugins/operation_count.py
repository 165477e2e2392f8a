"""How many floating-point operations an explicit step takes per triangle: counted, not estimated.

The kernels run as plain Python on numbers that count what is done to them: a sum, a product, a quotient and a square
root are one operation each; comparisons, reading and writing are none. `python -m plugins.operation_count` prints
{element: {kernel: operations per triangle and step}} of a sheet that flows, by itself, because kernels are compiled or
not for a whole process.
"""

import json
import math
import os
import subprocess
import sys

import numpy as np

SIDE, STEPS = 10, 4  # squares along the sheet; steps until its points flow
COUNTED = {
    "solver.explicit.sheet_pass": ("shell_pass", "membrane_pass", "gather_forces"),
    "solver.explicit.dynamics": ("predict", "account", "gather_thickness"),
}


class Number(float):
    """A number that counts the operations on it."""

    count = 0

    def __neg__(self):
        return Number(-float(self))

    def __abs__(self):
        return Number(abs(float(self)))


def _counting(name):
    plain = getattr(np.float64, name)  # divides by zero, as the kernels do

    def operation(self, other):
        Number.count += 1
        return Number(plain(np.float64(self), float(other)))

    return operation


for _name in ("add", "sub", "mul", "truediv", "pow"):
    for _side in ("", "r"):
        setattr(Number, f"__{_side}{_name}__", _counting(f"__{_side}{_name}__"))


def counted_root(value):
    """Square root, one operation."""
    Number.count += 1
    return Number(math.sqrt(value))


def as_numbers(argument):
    """Arrays of floats as arrays of numbers that count, alone and in a NamedTuple; anything else as it is."""
    if isinstance(argument, np.ndarray) and argument.dtype == float:
        numbers = np.empty(argument.shape, dtype=object)
        numbers.ravel()[:] = [Number(value) for value in argument.ravel()]
        return numbers
    if isinstance(argument, float):
        return Number(argument)
    if isinstance(argument, tuple) and hasattr(argument, "_fields"):
        return type(argument)(*map(as_numbers, argument))
    return argument


def counted(kernel, name, counts):
    """The kernel on numbers that count; what it does is added to counts[name]."""

    def call(*arguments):
        numbers = [as_numbers(argument) for argument in arguments]
        before, plain = Number.count, (np.empty, np.zeros)
        np.empty = np.zeros = lambda shape: np.full(shape, Number(0.0), dtype=object)
        try:
            kernel(*numbers)
        finally:
            np.empty, np.zeros = plain
        counts[name] = counts.get(name, 0) + Number.count - before
        for argument, number in zip(arguments, numbers, strict=True):
            if isinstance(argument, np.ndarray) and argument.dtype == float:
                argument[...] = number.astype(float)

    return call


def count():
    """{element: {kernel: operations per triangle and step}}. The kernels must not be compiled."""
    from .bench_explicit import ELEMENTS, stretched

    # Square roots of the kernels count, too.
    for module in list(sys.modules.values()):
        if getattr(module, "__name__", "").startswith("solver.") and getattr(module, "sqrt", None) is math.sqrt:
            module.sqrt = counted_root
    found = {}
    for name, element in ELEMENTS.items():
        dynamics = stretched(element, 2 * SIDE**2)
        for _ in range(STEPS):
            dynamics.step(0.0, dynamics.limit, dynamics.limit)
        counts, kept = {}, []
        for path, kernels in COUNTED.items():
            module = sys.modules[path]
            for kernel in kernels:
                kept.append((module, kernel, getattr(module, kernel)))
                setattr(module, kernel, counted(getattr(module, kernel), kernel, counts))
        try:
            dynamics.step(0.0, dynamics.limit, dynamics.limit)
        finally:
            for module, kernel, plain in kept:
                setattr(module, kernel, plain)
        m = len(dynamics.sheet.triangles.cells)
        found[name] = {kernel: total / m for kernel, total in counts.items()}
    return found


def counted_apart():
    """What `count` finds, in a process of its own."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "plugins.operation_count"], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


if __name__ == "__main__":
    with np.errstate(all="ignore"):
        print(json.dumps(count()))
