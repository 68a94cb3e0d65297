"""`enhance` and `renderer` as libraries: true lists of names, nothing loaded or changed by importing them."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tomllib
from inspect import getsource
from pathlib import Path
from types import ModuleType

import pytest

import enhance
import renderer

ROOT = Path(__file__).resolve().parents[1]
FACES = pytest.mark.parametrize("face", [enhance, renderer], ids=lambda face: face.__name__)
HEAVY = ("numpy", "cv2", "numba", "pydantic", "torch", "moderngl", "PIL")
OF_OPENGL = {"OpenGLUnavailable", "SplatView", "render_offscreen", "standalone_context"}


def said(script: str, folder: Path = ROOT, **variables: str) -> str:
    """By a fresh process, in which OpenMP is as it comes."""
    inherited = {name: value for name, value in os.environ.items() if name != "OMP_WAIT_POLICY"}
    environment = inherited | {"PYTHONPATH": str(ROOT)} | variables
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder, env=environment, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@FACES
def test_the_list_of_names_is_true(face: ModuleType) -> None:
    assert face.__all__ == sorted(face.__all__) == dir(face)
    for name in face.__all__:
        assert getattr(face, name) is not None
        assert f"`{name}`" in (face.__doc__ or ""), name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        face.nothing  # noqa: B018


@FACES
def test_no_other_name_is_there_but_folders_and_files(face: ModuleType) -> None:
    public = {name for name, value in vars(face).items() if not name.startswith("_")}
    own = {path.stem for path in Path(str(face.__file__)).parent.iterdir()}
    assert public - set(face.__all__) <= own


@FACES
def test_types_are_told_of_the_same_names(face: ModuleType) -> None:
    """Type checkers read the imports, programs the table."""
    checked = {
        name.asname or name.name: statement.module
        for statement in ast.walk(ast.parse(getsource(face)))
        if isinstance(statement, ast.ImportFrom)
        for name in statement.names
    }
    assert checked == face._HOME
    assert sorted(checked) == face.__all__


def test_importing_loads_nothing() -> None:
    script = "import sys, enhance, renderer; print([name for name in {!r} if name in sys.modules])"
    assert said(script.format(HEAVY)) == "[]"


def test_no_name_loads_torch_and_few_opengl() -> None:
    few = f"[getattr(renderer, name) for name in renderer.__all__ if name not in {OF_OPENGL!r}]"
    script = f"import sys, enhance, renderer; from enhance import *; {few}"
    assert said(f"{script}; print([name for name in {HEAVY!r} if name not in sys.modules])") == (
        "['torch', 'moderngl']"
    )


@pytest.mark.parametrize("name", ["clahe", "dvbv_local", "vesselness", "EnhanceParams", "ImageError"])
def test_what_has_no_kernels_loads_no_compiler(name: str) -> None:
    assert said(f"import sys, enhance; enhance.{name}; print('numba' in sys.modules)") == "False"


@pytest.mark.parametrize("name", ["train", "rasterize"])
def test_a_function_keeps_its_name_beside_a_folder_of_the_same(name: str) -> None:
    module = {"train": "renderer.train.trainer", "rasterize": "renderer.rasterize.cpu"}[name]
    for first in (f"from {module} import *", f"import renderer; renderer.{name}", f"import {module}"):
        script = f"{first}\nimport {module}\nfrom renderer import {name} as one\nprint(one.__name__)"
        assert said(script) == name


STATE = """
import importlib, os, pkgutil, signal, sys, threading, warnings
import cv2, numba, numpy
import av, matplotlib, moderngl, PIL.Image, pydantic.dataclasses, safetensors.numpy, torch


def state():
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    settings = {name: value for name, value in vars(numba.config).items() if name.isupper()}
    return {
        "environment": dict(os.environ), "handlers": handlers, "warnings": list(warnings.filters),
        "OpenCV": (cv2.getNumThreads(), cv2.useOptimized(), cv2.ocl.useOpenCL()), "numba": settings,
        "numpy": (numpy.geterr(), numpy.random.get_state()[1].tolist()), "path": list(sys.path),
        "hooks": (sys.excepthook, sys.unraisablehook, sys.displayhook), "threads": threading.active_count(),
        "torch": (torch.get_num_threads(), torch.get_default_dtype(), torch.is_grad_enabled()),
        "pictures": PIL.Image.MAX_IMAGE_PIXELS, "folder": os.getcwd(), "recursion": sys.getrecursionlimit(),
    }


before, count = state(), 0
for package in ("enhance", "renderer"):
    for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
        importlib.import_module(module.name)
        count += 1
after = state()
print(count, [name for name in before if before[name] != after[name]])
"""


def test_importing_changes_nothing_of_the_process() -> None:
    """What other libraries do when they load has been done before."""
    count, changed = said(STATE).split(maxsplit=1)
    assert int(count) > 100
    assert changed == "[]"


@FACES
def test_types_go_with_the_wheel(face: ModuleType) -> None:
    folder = Path(str(face.__file__)).parent
    assert (folder / "py.typed").read_bytes() == b""
    targets = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]
    assert folder.name in targets["wheel"]["packages"]
    assert targets["wheel"]["exclude"] == ["assets/pictures"]
    assert folder.name in targets["sdist"]["include"]
    ignored = (ROOT / ".gitignore").read_text().splitlines()
    assert not any(Path("py.typed").match(pattern.rstrip("/")) for pattern in ignored)


def test_the_package_is_not_for_the_public_index() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert "Private :: Do Not Upload" in project["classifiers"]


def test_the_example_of_the_readme_runs(tmp_path: Path) -> None:
    [example] = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    shapes = "print(result.image.shape, view.image.shape, callable(rasterize))"
    assert said(f"{example}\n{shapes}", tmp_path) == "(48, 64, 3) (48, 64, 3) True"
