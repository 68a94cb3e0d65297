"""How numba's threads wait for each other, in every process that this program starts."""

from __future__ import annotations

import os


def rest_while_waiting() -> None:
    """To be called before OpenMP is loaded, which reads this once; what the user has set stays.

    Threads spin while they wait unless told otherwise. Where anything else runs on the same cores, such as
    the window beside a training job, each wait then costs a whole time slice: a training step takes four
    times as long.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
