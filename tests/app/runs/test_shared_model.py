"""The newest model in shared memory: its reader never waits, sees whole models only, and nothing is left."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from app.runs import shared_model
from app.runs.shared_model import PREFIX, SEQUENCE, Slot, SlotReader, SlotWriter
from renderer.deformation.motion import Still
from renderer.gaussians import DynamicGaussians
from renderer.train.initialize import round_gaussians
from tests.app.fake_steps import model_of


@pytest.fixture
def slot() -> Iterator[Slot]:
    made = Slot.make(multiprocessing.get_context("spawn"))
    yield made
    SlotReader(made).close()


def test_the_reader_of_a_busy_slot_keeps_what_it_has(slot: Slot) -> None:
    writer, reader = SlotWriter(slot), SlotReader(slot)
    assert reader.newest() is None
    writer.write(model_of(3))
    first = reader.newest()
    writer.write(model_of(4))
    slot.state[SEQUENCE] += 1  # As a writer that was killed in the middle leaves it.
    assert reader.newest() is first
    slot.state[SEQUENCE] -= 1
    newest = reader.newest()
    assert first is not None
    assert newest is not None
    assert (len(first), len(newest)) == (3, 4)
    # What was read is a copy: writing again does not change it.
    writer.write(model_of(5))
    assert np.array_equal(newest.means, model_of(4).means)
    reader.close()


def uniform(value: int) -> DynamicGaussians:
    """Every position is the same number."""
    count = 3000 + 500 * (value % 7)
    means = np.full((count, 3), value, np.float32)
    return DynamicGaussians(round_gaussians(means, np.ones(count), means, 0.5), Still())


def test_no_model_is_read_in_part_while_it_is_overwritten(slot: Slot) -> None:
    writer, reader, ended = SlotWriter(slot), SlotReader(slot), threading.Event()

    def write() -> None:
        for value in range(400):
            writer.write(uniform(value))
        ended.set()

    thread = threading.Thread(target=write)
    thread.start()
    seen = set()
    while not ended.is_set():
        model = reader.newest()
        if model is not None:
            assert len(np.unique(model.means)) == 1
            assert len(model) == len(uniform(int(model.means[0, 0])))
            seen.add(int(model.means[0, 0]))
    thread.join()
    last = reader.newest()
    assert last is not None
    assert last.means[0, 0] == 399
    assert len(seen) > 1
    reader.close()


def test_blocks_of_processes_that_are_gone_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    gone, ours, other = (
        tmp_path / f"{PREFIX}{ended.pid}-abcd-1",
        tmp_path / f"{PREFIX}{os.getpid()}-abcd-1",
        tmp_path / f"{PREFIX}not-ours",
    )
    for block in (gone, ours, other):
        block.write_bytes(b"model")
    monkeypatch.setattr(shared_model, "SHARED", tmp_path)
    Slot.make(multiprocessing.get_context("spawn"))
    assert sorted(tmp_path.iterdir()) == sorted([ours, other])


@pytest.mark.skipif(not shared_model.SHARED.is_dir(), reason="blocks are listed on Linux alone")
def test_no_semaphore_or_block_outlives_processes_that_are_killed_together() -> None:
    """Their group is killed, the tracker of shared memory with them; the next start clears what is left."""
    before = set(shared_model.SHARED.iterdir())
    script = (
        "import multiprocessing, time\n"
        "from app.runs.shared_model import Slot, SlotWriter\n"
        "from tests.app.fake_steps import model_of\n"
        "slot = Slot.make(multiprocessing.get_context('spawn'))\n"
        "SlotWriter(slot).write(model_of(3))\n"
        "print('ready', flush=True)\n"
        "time.sleep(60)\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, start_new_session=True
    ) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == b"ready\n"
        os.killpg(child.pid, 9)
    left = set(shared_model.SHARED.iterdir()) - before
    assert {block.name.split("-")[1].split(".")[0] for block in left} == {str(child.pid)}
    Slot.make(multiprocessing.get_context("spawn"))
    assert set(shared_model.SHARED.iterdir()) - before == set()
