"""The pinned versions exist and agree on every system of the README, by the public index alone.

Only metadata is downloaded. Without an index within reach, as on a machine that is offline, this is skipped.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.app.conftest import ROOT

PLATFORMS = {
    "Linux": ("x86_64-unknown-linux-gnu", {}),
    "Windows": ("x86_64-pc-windows-msvc", {}),
    # PyAV's wheels begin at this macOS; for Intel processors torch and others have none any more.
    "macOS": ("aarch64-apple-darwin", {"MACOSX_DEPLOYMENT_TARGET": "14.0"}),
}
PYTHONS = ("3.11", "3.12", "3.13")
LOCAL = ("PIP_", "UV_")
"""Beginnings of the names of what a machine sets for itself."""
CARD = ("cuda-", "nvidia-", "triton")
"""Beginnings of the names of what torch's build for NVIDIA cards brings, in versions of its own."""
EXTRAS = ("--extra", "test", "--extra", "bundle")


def resolve(
    requirements: str, cache: Path, *arguments: str, **variables: str
) -> subprocess.CompletedProcess[str]:
    """What the public index gives for them, wheels alone but for one."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(LOCAL)}
    line = [sys.executable, "-m", "uv", "pip", "compile", "--no-config", "--no-header", "--no-annotate"]
    # uv would fetch an interpreter of the version asked for; its markers and wheels are all that is needed.
    line += [
        "--no-python-downloads",
        "--quiet",
        "--only-binary",
        ":all:",
        # Below pyigtl; it has no wheels, and is plain Python where there is no compiler.
        "--no-binary",
        "crcmod",
        "--cache-dir",
        str(cache),
        requirements,
        *arguments,
    ]
    return subprocess.run(
        line, cwd=ROOT, env=environment | variables, capture_output=True, text=True, timeout=300
    )


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of an index that answers."""
    assert find_spec("uv") is not None, "expected uv of the extra test: make test installs it"
    folder = tmp_path_factory.mktemp("resolved")
    (folder / "one.txt").write_text("iniconfig\n")
    asked = resolve(str(folder / "one.txt"), folder / "cache", UV_HTTP_TIMEOUT="10", UV_HTTP_RETRIES="0")
    if asked.returncode != 0:
        pytest.skip("no package index can be reached from here")
    return folder / "cache"


@pytest.mark.slow
def test_the_pins_resolve_on_every_system_and_python(cache: Path) -> None:
    def one(case: tuple[str, str]) -> str:
        system, python = case
        platform, variables = PLATFORMS[system]
        done = resolve(
            "pyproject.toml", cache, *EXTRAS, "--constraint", "constraints.txt",
            "--python-platform", platform, "--python-version", python, **variables,
        )  # fmt: skip
        return done.stdout if done.returncode == 0 else f"{system}, {python}: {done.stderr}"

    cases = [(system, python) for system in PLATFORMS for python in PYTHONS]
    with ThreadPoolExecutor(len(cases)) as pool:
        answers = dict(zip(cases, pool.map(one, cases), strict=True))
    torch, pinned = pins()["torch"], {plain(name) for name in pins()}
    for case, text in answers.items():
        assert f"torch=={torch}\n" in text, case
        if case[0] == "Linux":  # Where the tests run.
            names = {plain(line.partition("==")[0]) for line in text.splitlines() if "==" in line}
            assert not {name for name in names - pinned if not name.startswith(CARD)}, case
    assert "colorama" in answers["Windows", "3.12"], "the markers of another system were not heard"


@pytest.mark.slow
@pytest.mark.parametrize("overrides", ["install/without-torch.txt", "install/bundle/overrides.txt"])
def test_what_is_left_out_stays_out(cache: Path, overrides: str) -> None:
    pinned = ("--constraint", "constraints.txt", "--overrides", overrides)
    done = resolve("pyproject.toml", cache, "--extra", "bundle", *pinned)
    assert done.returncode == 0, done.stderr
    names = {line.partition("==")[0] for line in done.stdout.splitlines()}
    left_out = {line.partition(" ")[0] for line in (ROOT / overrides).read_text().splitlines() if ";" in line}
    assert "torch" in left_out
    assert names & {"numpy", "numba", "imgui-bundle"} == {"numpy", "numba", "imgui-bundle"}
    assert not names & left_out
    assert not any(name.startswith(("nvidia-", "triton")) for name in names)


def test_every_dependency_is_pinned_to_a_version_of_the_public_index() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [name for extra in project["optional-dependencies"].values() for name in extra]
    for name in [*project["dependencies"], *extras]:
        assert name.partition(">")[0] in pins(), name
    # A label after a plus sign names a build of one machine or of another index.
    assert not [version for version in pins().values() if "+" in version]


def plain(name: str) -> str:
    """As an index compares names."""
    return name.replace("_", "-").lower()


def pins() -> dict[str, str]:
    """Versions by name."""
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))
