"""Checked and set before anything else is loaded: the program's own packages, its threads, a screen."""

from __future__ import annotations

import os
import sys
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path
from threading import RLock
from typing import Any, Final

from app.errors import UserError

PACKAGES = ("app", "renderer", "enhance", "assets")
THREADS: Final = "NUMBA_NUM_THREADS"
MOST_THREADS: Final = 1024
"""Each has memory of its own and is begun for nothing on most machines; of too many the system ends all."""


def require_one_place() -> None:
    """The packages have names that others may have, too: those found must be the program's own.

    Nothing is imported, only looked up.

    Raises:
        UserError: one of the packages is missing, or is somebody else's: it lies elsewhere than `app`.
    """
    if getattr(sys, "frozen", False):
        return  # A bundle holds nothing but itself.
    home = Path(__file__).resolve().parents[2]
    for name in PACKAGES:
        spec = find_spec(name)
        if spec is None:
            raise UserError(
                f"expected {_listed()} in one folder, got no {name} in {home}: reinstall VesselSplat"
            )
        found = _path(spec)
        if found.parent != home:
            raise UserError(
                f"expected {_listed()} in one folder, {home}, got another {name}: {found} "
                "(start from another folder, or leave that one out of PYTHONPATH)"
            )


def _path(spec: ModuleSpec) -> Path:
    """Folder of a package, or file of a module; nowhere, of what Python itself holds."""
    places = list(spec.submodule_search_locations or ())
    return Path(places[0] if places else spec.origin or "").resolve()


def _listed() -> str:
    *most, last = PACKAGES
    return f"{', '.join(most)} and {last}"


def require_threads() -> None:
    """Before numba reads how many threads it is to have: it takes what is no number as if nothing were said.

    Raises:
        UserError: the environment says none, more than MOST_THREADS or no number.
    """
    said = os.environ.get(THREADS, "")
    is_number = said.isascii() and said.isdecimal()
    if said and not (is_number and 1 <= int(said) <= MOST_THREADS):
        raise UserError(f"expected {THREADS} from 1 to {MOST_THREADS} in the environment, got {said!r}")


def rest_while_waiting() -> None:
    """How numba's threads wait for each other, in every process that this program starts.

    To be called before OpenMP is loaded, which reads this once; what the user has set stays.

    Threads spin while they wait unless told otherwise. Where anything else runs on the same cores, such as
    the window beside a training job, each wait then costs a whole time slice: a training step takes four
    times as long.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


def take_turns_where_needed() -> None:
    """Kernels of different threads run one after the other, where numba has no threads but its own.

    Those end the process when two threads compute at a time. numba takes them where neither OpenMP nor TBB
    can be loaded: macOS brings neither, and the wheel of numba holds none.
    """
    import numba
    from numba.core.dispatcher import Dispatcher

    numba.get_num_threads()  # Only then it has chosen.
    if numba.threading_layer() != "workqueue":  # type: ignore[attr-defined]
        return
    turn, call = RLock(), Dispatcher.__call__

    def called(kernel: Dispatcher, *args: Any, **keywords: Any) -> Any:
        with turn:
            return call(kernel, *args, **keywords)

    Dispatcher.__call__ = called  # type: ignore[assignment, method-assign]


def has_display() -> bool:
    """For a window: always on Windows and macOS; elsewhere when an X or Wayland server is named."""
    if not sys.platform.startswith(("linux", "freebsd")):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
