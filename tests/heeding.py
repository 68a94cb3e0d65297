"""Signals as a terminal gives them, however the tests were started."""

from __future__ import annotations

import signal


def heed_signals() -> None:
    """A shell in the background has them ignored, and so has nohup; every process that is tried would take
    that over."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in {"SIGTERM", "SIGHUP"} & vars(signal).keys():
        signal.signal(getattr(signal, name), signal.SIG_DFL)
