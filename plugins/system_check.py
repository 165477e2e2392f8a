"""Names the system packages a bare Debian or Ubuntu still lacks, before anything is downloaded.

Runs on the system's own Python, with the standard library only: `python3 -I plugins/system_check.py`.
"""

import ctypes
import importlib.util
import sys

# library -> Debian package; gmsh, OCP and off-screen pictures load these when imported or when they draw
PACKAGE_OF_LIBRARY = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libGLU.so.1": "libglu1-mesa",
    "libXcursor.so.1": "libxcursor1",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libgomp.so.1": "libgomp1",
}


def missing_libraries(load=ctypes.CDLL):
    """The shared libraries of PACKAGE_OF_LIBRARY that the loader does not find; none outside Linux."""
    missing = []
    if sys.platform.startswith("linux"):
        for library in PACKAGE_OF_LIBRARY:
            try:
                load(library)
            except OSError:
                missing.append(library)
    return missing


def missing_packages(load=ctypes.CDLL, find=importlib.util.find_spec):
    """Debian packages to install: those of the libraries, and python3.x-venv where `venv` cannot work."""
    packages = [PACKAGE_OF_LIBRARY[library] for library in missing_libraries(load)]
    if find("venv") is None or find("ensurepip") is None:
        packages.insert(0, f"python{sys.version_info[0]}.{sys.version_info[1]}-venv")
    return packages


def main(arguments):
    """Exit status 0: all there. 1: one line says what to install (`--packages`: the bare names only)."""
    packages = missing_packages()
    if not packages:
        return 0
    names = " ".join(packages)
    if "--packages" in arguments:
        print(names)
    else:
        print(f"cadlink needs system packages: apt-get install --no-install-recommends {names}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
