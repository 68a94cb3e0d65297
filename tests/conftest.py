"""One OpenGL context without a window for the whole run, and a watch on errors around every test of it."""

from __future__ import annotations

import gc
import os
import shutil
from ast import literal_eval
from collections.abc import Callable, Iterator
from functools import cache, lru_cache, partial
from hashlib import sha256
from math import isqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import moderngl
import numpy as np
import pytest
from filelock import FileLock
from hypothesis import settings

from app.console.startup import has_display
from renderer.draw.context import OpenGLUnavailable, standalone_context
from renderer.phantom.tissue import Tissue, paint_tissue
from tests.heeding import heed_signals

# The first example of a test may compile kernels, which has nothing to do with what it asserts.
settings.register_profile("compiling", deadline=None)
settings.load_profile("compiling")


SUITE_FOLDER = "VESSELSPLAT_SUITE_FOLDER"
"""Variable that names to all processes of the suite the folder of what they share."""


def pytest_configure(config: pytest.Config) -> None:
    heed_signals()
    if SUITE_FOLDER not in os.environ:
        # The first process; pytest would keep gigabytes of painted tissue for its next three sessions.
        folder = TemporaryDirectory(prefix="vesselsplat-suite-", ignore_cleanup_errors=True)
        os.environ[SUITE_FOLDER] = folder.name
        config.add_cleanup(partial(os.environ.pop, SUITE_FOLDER))
        config.add_cleanup(folder.cleanup)
    # Where the processor draws windows: threads of it would wait for those of the suite's other process.
    os.environ.setdefault("LP_NUM_THREADS", "0")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Windows first: X ends a process that has had a context without a window, and then opens one."""
    items.sort(key=lambda item: item.get_closest_marker("display") is None)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """A window without a screen ends the process by an assertion: skipped before, but a failure in CI."""
    if item.get_closest_marker("display") is not None and not has_display():
        lacks = "no display, and no Xvfb to make one: apt-get install xvfb"
        pytest.fail(lacks) if os.environ.get("CI") else pytest.skip(lacks)


@pytest.fixture(scope="session")
def gl_context() -> Iterator[moderngl.Context]:
    """The session's context. Without OpenGL its tests are skipped, but fail where CI is set."""
    try:
        ctx = standalone_context()
    except OpenGLUnavailable as error:
        if os.environ.get("CI"):
            pytest.fail(str(error))
        pytest.skip(str(error))
    yield ctx
    ctx.release()


@pytest.fixture
def ctx(gl_context: moderngl.Context) -> Iterator[moderngl.Context]:
    """The session's context, which a test finds and must leave without an OpenGL error."""
    with gl_context:
        assert gl_context.error == "GL_NO_ERROR"
        yield gl_context
        assert gl_context.error == "GL_NO_ERROR"


def pytest_collection_finish() -> None:
    """What the suite itself consists of is half a million objects, which every full collection of garbage, as
    of each window at rest, would go through."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def made_once() -> Callable[[str, Callable[[Path], object]], Path]:
    """A folder by that name, which the first process of the suite to want it makes for all. Read only."""

    suite_folder = Path(os.environ[SUITE_FOLDER])

    def made(name: str, make: Callable[[Path], object]) -> Path:
        folder, done = suite_folder / name, suite_folder / f"{name}.made"
        with FileLock(suite_folder / f"{name}.lock"):
            if not done.exists():
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                make(folder)
                done.touch()
        return folder

    return made


@pytest.fixture(scope="session", autouse=True)
def painted_once(made_once: Callable[..., Path]) -> Iterator[None]:
    """To paint the tissue takes most of the time of a small phantom, and few seeds are used: what one process
    of the suite has painted, all map into their memory."""

    @cache
    def painted(state: str) -> Tissue:
        def store(folder: Path) -> None:
            rng = np.random.default_rng()
            rng.bit_generator.state = literal_eval(state)
            tissue = paint_tissue(rng)
            np.save(folder / "tissue.npy", np.concatenate([part.ravel() for part in vars(tissue).values()]))

        path = made_once(f"tissue-{sha256(state.encode()).hexdigest()[:16]}", store) / "tissue.npy"
        stored = np.load(path, mmap_mode="c")
        texels = len(stored) // 6
        side = isqrt(texels)
        albedo, vessels, relief = np.split(stored, (3 * texels, 4 * texels))
        return Tissue(
            albedo.reshape(side, side, 3), vessels.reshape(side, side), relief.reshape(side, side, 2)
        )

    def paint(rng: np.random.Generator) -> Tissue:
        return painted(str(rng.bit_generator.state))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("renderer.phantom.paint_tissue", paint)
        patch.setattr(Tissue, "blurred", lru_cache(maxsize=3)(Tissue.blurred))
        yield
