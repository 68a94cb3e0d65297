"""The newest model of a training process, in shared memory: one slot, overwritten, never queued.

The training process writes, the window reads. The reader never waits: while the slot is being written, or
if the writer died meanwhile, it keeps what it has. There is no lock, which a killed process could take along.
"""

from __future__ import annotations

import ctypes
import os
import re
import secrets
import sys
import threading
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.context import SpawnContext
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from typing import Final

import numpy as np
from safetensors.numpy import load, save

from renderer.gaussians import DynamicGaussians
from renderer.leftovers import lives, mark_of

PREFIX: Final = "vs-"
"""Of the names of blocks; the mark of the window's process follows."""
SHARED: Final = Path("/dev/shm")
"""Where Linux keeps them."""
SEQUENCE: Final = 2
"""Place of the sequence number."""
_MUTEX = threading.Lock()


@dataclass(frozen=True)
class Slot:
    """What both processes know: the blocks' common name, and which block holds what."""

    name: str
    state: ctypes.Array[ctypes.c_longlong]
    """(generation of the block, bytes in use, sequence number); all 0 before the first write. The number is
    odd while the others, or the block, are being written."""

    @classmethod
    def make(cls, context: SpawnContext) -> Slot:
        """A new one; blocks of processes that are gone are removed."""
        clear_blocks()
        # macOS allows blocks names of 30 characters.
        return cls(
            f"{PREFIX}{mark_of(os.getpid())}-{secrets.token_hex(2)}", context.RawArray(ctypes.c_longlong, 3)
        )

    def block_name(self, generation: int) -> str:
        return f"{self.name}-{generation}"


@dataclass
class SlotWriter:
    """The end of a slot that the training process writes."""

    slot: Slot
    _block: SharedMemory | None = None

    def write(self, model: DynamicGaussians) -> None:
        """Put `model` in the slot; a larger block takes the place of one that is too small.

        Raises OSError: shared memory has no room for it; the slot keeps what it has.
        """
        content = save({name: np.ascontiguousarray(value) for name, value in model.arrays().items()})
        generation, _, sequence = self.slot.state[:]
        block = self._block
        if block is None or block.size < len(content):
            generation += 1
            block = self._grown(generation, len(content))
        else:
            _reserve(block, len(content))
        self.slot.state[SEQUENCE] = sequence + 1
        _order()
        assert block.buf is not None
        block.buf[: len(content)] = content
        self.slot.state[:SEQUENCE] = [generation, len(content)]
        _order()
        self.slot.state[SEQUENCE] = sequence + 2

    def _grown(self, generation: int, needed: int) -> SharedMemory:
        larger = SharedMemory(self.slot.block_name(generation), create=True, size=2 * needed)
        try:
            _reserve(larger, needed)
        except OSError:
            _remove(larger)
            raise
        if self._block is not None:
            _remove(self._block)
        self._block = larger
        return larger


@dataclass
class SlotReader:
    """The window's end. Owns the blocks' removal, since the writer may be killed at any moment."""

    slot: Slot
    _block: SharedMemory | None = None
    _generation: int = 0
    _sequence: int = 0
    _newest: DynamicGaussians | None = field(default=None, repr=False)

    def newest(self) -> DynamicGaussians | None:
        """The last model written; the same object as long as there is no newer one."""
        content = self._take()
        if content is not None:
            self._newest = DynamicGaussians.from_arrays(load(content))
        return self._newest

    def _take(self) -> bytes | None:
        sequence = self.slot.state[SEQUENCE]
        if sequence == self._sequence or sequence % 2:
            return None
        _order()
        generation, size = self.slot.state[:SEQUENCE]
        block = self._attached(generation)
        content = None if block is None or block.buf is None else bytes(block.buf[:size])
        _order()
        if self.slot.state[SEQUENCE] != sequence:
            return None  # It was overwritten meanwhile: the next one is whole.
        self._sequence = sequence
        return content

    def _attached(self, generation: int) -> SharedMemory | None:
        if generation != self._generation:
            if self._block is not None:
                self._block.close()
            self._block, self._generation = _open(self.slot.block_name(generation)), generation
        return self._block

    def close(self) -> None:
        """Remove every block. Call when the writer has ended."""
        if self._block is not None:
            self._block.close()
        generation = self.slot.state[0]
        # A writer killed while it grew can leave the block before or after the one it announced.
        for number in range(max(generation - 1, 1), generation + 2):
            block = _open(self.slot.block_name(number))
            if block is not None:
                _remove(block)
        self._block, self._generation = None, 0


def _reserve(block: SharedMemory, size: int) -> None:
    """Raises OSError: there is no room for so many bytes. Linux makes blocks larger than its room, and kills
    who writes beyond that; other systems refuse to make them."""
    if sys.platform == "linux":
        with (SHARED / block.name).open("rb+") as opened:
            os.posix_fallocate(opened.fileno(), 0, size)


def _remove(block: SharedMemory) -> None:
    block.close()
    block.unlink()


def _order() -> None:
    """What is read and written before stays before, also on processors that would change the order."""
    for _ in range(2):
        with _MUTEX:
            pass


def clear_blocks() -> None:
    """Blocks of windows that were killed together with their training. Only Linux lists them."""
    for block in SHARED.glob(f"{PREFIX}*-*"):
        mark = block.name.removeprefix(PREFIX).split("-")[0]
        if re.fullmatch(r"\d+(\.\d+)?", mark) and not lives(mark):
            with suppress(OSError):
                block.unlink()


def _open(name: str) -> SharedMemory | None:
    try:
        return SharedMemory(name)
    except FileNotFoundError:
        return None
