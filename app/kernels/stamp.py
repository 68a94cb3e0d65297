"""A note in the user's cache folder that all kernels are compiled: for these sources, on this CPU.

Compiled kernels lie where numba keeps them. Whether all are there is found without loading any of them.
"""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Iterator
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import platformdirs

from app.errors import UserError
from app.files.atomic import make_folder, write_bytes
from renderer.json_files import read_json

ROOT = Path(__file__).parents[2]
PACKAGES = ("enhance", "renderer")
"""Those with kernels."""


def is_prepared() -> bool:
    """Whether everything was compiled and still lies there; False too where that cannot be found out."""
    try:
        told = read_json(_stamp())
        files = [Path(name) for name in told["files"]]
        return told["key"] == _key() and bool(files) and all(path.exists() for path in files)
    except (OSError, ValueError, KeyError, TypeError):
        return False


def note_prepared() -> None:
    """All kernels that this process has used are compiled. Where nothing can be written, nothing is noted."""
    files = sorted({str(path) for folder in _cache_folders() for path in folder.glob("*.nbi")})
    content = json.dumps({"key": _key(), "files": files}, indent=1).encode()
    with suppress(OSError, UserError):
        make_folder(_stamp().parent)
        write_bytes(_stamp(), content)


def _stamp() -> Path:
    """One for each installation and each folder of kernels."""
    place = f"{ROOT}\n{os.environ.get('NUMBA_CACHE_DIR', '')}"
    name = f"kernels-{sha256(place.encode()).hexdigest()[:12]}.json"
    return platformdirs.user_cache_path("vesselsplat", False) / name


def _key() -> str:
    """Of all that decides whether a compiled kernel can be used, as numba looks at it: sources by size and
    time, versions, CPU."""
    from importlib.metadata import version

    import llvmlite
    from llvmlite.binding import get_host_cpu_name

    facts = [get_host_cpu_name(), platform.machine(), sys.version, version("numba"), llvmlite.__version__]
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            found = path.stat()
            facts.append(f"{path.relative_to(ROOT)} {found.st_size} {found.st_mtime_ns}")
    return sha256("\n".join(facts).encode()).hexdigest()


def _cache_folders() -> Iterator[Path]:
    """Of the kernels that are loaded."""
    for kernel in loaded_kernels().values():
        yield Path(kernel.stats.cache_path)


def loaded_kernels() -> dict[str, Any]:
    """The kernels of the loaded modules that numba keeps on disk, by name."""
    from numba.core.caching import NullCache
    from numba.core.dispatcher import Dispatcher

    return {
        f"{name}.{key}": value
        for name, module in tuple(sys.modules.items())
        if name.split(".")[0] in PACKAGES
        for key, value in vars(module).items()
        if isinstance(value, Dispatcher)
        and value.py_func.__module__ == name
        and not isinstance(getattr(value, "_cache", None), NullCache)
    }
