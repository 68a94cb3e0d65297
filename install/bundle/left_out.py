"""What the bundle goes without, and why."""

from __future__ import annotations

from typing import Final

LARGE: Final = ("torch", "torchvision", "triton", "gsplat", "functorch", "torchgen")
"""Several gigabytes for faces that say themselves what to install."""
COPYLEFT: Final = ("av", "readline", "_gdbm", "dbm.gnu")
"""Their binaries are GPL: x264 and x265 in PyAV's, GNU Readline and gdbm by way of Python's own modules."""
UNUSED: Final = (
    *(
        "tkinter",
        "_tkinter",
        "IPython",
        "PyQt5",
        "PyQt6",
        "PySide2",
        "PySide6",
        "gi",
        "wx",
        "scipy",
        "pandas",
    ),
    *("pytest", "hypothesis", "mypy", "setuptools", "pip", "wheel", "pydoc", "doctest", "lib2to3", "idlelib"),
    *("imgui_bundle.demos_python", "imgui_bundle.demos_cpp", "numba.tests", "numba.cuda.tests"),
    *("matplotlib.tests", "numpy.tests", "mpl_toolkits"),
)
"""By no command; some packages try to import them."""
EXCLUDED: Final = (*LARGE, *COPYLEFT, *UNUSED)
"""For PyInstaller."""
FORBIDDEN_FILES: Final = (
    "libx264",
    "libx265",
    "libxvid",
    "libreadline",
    "libgdbm",
    "libpostproc",
    "libtorch",
)
"""Beginnings of the names of libraries that must not get in by another way."""
OF_THE_SYSTEM: Final = (
    *(
        "libstdc++.",
        "libgcc_s.",
        "libX11.",
        "libX11-xcb.",
        "libxcb.",
        "libXau.",
        "libXdmcp.",
        "libbsd.",
        "libmd.",
    ),
    *("libGL.", "libGLX.", "libGLdispatch.", "libEGL.", "libOpenGL.", "libdrm."),
)
"""Beginnings of the names of libraries of Linux that the graphics driver loads as well: an older one of the
bundle would keep it from loading."""
