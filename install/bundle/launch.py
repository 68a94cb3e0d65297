"""Where the bundle begins: the command line, or a process that the window has spawned."""

from __future__ import annotations

import multiprocessing
import sys

if __name__ == "__main__":
    multiprocessing.freeze_support()  # Before all else: a spawned process goes no further than this.
    from app.__main__ import main

    sys.exit(main())
