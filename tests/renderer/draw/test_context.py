"""A context, or one sentence that says what is missing."""

from __future__ import annotations

from typing import Any

import moderngl
import pytest

from renderer.draw.context import OpenGLUnavailable, is_software, renderer_name, standalone_context


class Driver:
    """A context that knows nothing but the name of its renderer."""

    def __init__(self, name: str) -> None:
        self.info = {"GL_RENDERER": name}


def test_a_missing_driver_names_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Any, **__: Any) -> moderngl.Context:
        raise Exception("libEGL.so.1 not loaded")

    monkeypatch.setattr(moderngl, "create_context", missing)
    with pytest.raises(OpenGLUnavailable, match=r"3\.3.*libEGL\.so\.1 not loaded.*libegl1.*libgl1-mesa-dri"):
        standalone_context()


@pytest.mark.gl
def test_the_context_is_new_enough_and_has_a_name(ctx: moderngl.Context) -> None:
    assert ctx.version_code >= 330
    assert renderer_name(ctx)


@pytest.mark.parametrize(
    ("name", "software"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", True),
        ("Google SwiftShader", True),
        ("GDI Generic", True),
        ("NVIDIA GeForce RTX 3060/PCIe/SSE2", False),
        ("Mesa Intel(R) UHD Graphics (ADL GT2)", False),
        ("Apple M1", False),
    ],
)
def test_software_drivers_are_told_from_gpus(name: str, software: bool) -> None:
    assert is_software(Driver(name)) is software  # type: ignore[arg-type]
