"""Without torch all but its own faces works, and those say in one line what to install."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import enhance.stability
import renderer.measuring.stability
from app.report.bench import Bench, Clock
from app.report.measures import drawing, stability
from renderer.measuring.stability import BY_TORCH
from renderer.torch_presence import NO_TORCH
from tests.app.conftest import CONFIG, ROOT

HIDDEN = "import sys\nsys.modules['torch'] = None\n"
"""As a sitecustomize it holds in spawned processes, too."""
WORKING = """
phantom clip --frames 10 --size 48 40
enhance clip/images/frame-000001.color.png enhanced.png
train clip --run run --iterations 6
train clip --run fdm --iterations 4 --method deform3dgs
train clip --run planes --iterations 4 --method endogaussian --input enhanced
render run --out pictures --frames test --depth
export run --ply ply --video film.mp4 --cameras cameras.json
metrics enhanced.png --against clip/images/frame-000001.color.png
replay pictures/frame-000001.png
info
"""
IN_ONE_PROCESS = """
import sys
from app.__main__ import main

for line in sys.argv[1:]:
    if main(line.split()) != 0:
        sys.exit(line)
"""
OF_A_SPAWNED_PROCESS = """
import sys, time
from pathlib import Path
from app.runs.job import TrainingJob
from app.runs.train_run import TrainRequest
from renderer.train.config import TrainConfig

if __name__ == "__main__":
    job = TrainingJob(
        TrainRequest(clip_path=Path("clip"), run_path=Path("job"), config=TrainConfig(iterations=4))
    )
    job.start()
    end = time.monotonic() + 120
    while job.state in ("running", "paused") and time.monotonic() < end:
        for event in job.poll():
            print(event)
        time.sleep(0.05)
    job.close()
    sys.exit(job.state != "finished")
"""

WINDOW = """
import sys
from pathlib import Path

from app.gui.actions import actions
from app.gui.work.settings import Settings
from tests.app.gui.kept_session import places_in
from tests.app.gui.driver import Driver, is_settled, wait

driver = Driver(places_in(Path.cwd()), Settings())
state = driver.state


def drive(ctx):
    ctx.item_click("//Before you begin/I understand")
    actions.open_path(state, Path(sys.argv[1]))
    wait(ctx, lambda: is_settled(state) and state.scene.model is not None, "the run")
    name, banner = state.source.clip.name, state.window.banner
    print(len(state.scene.model.model), "Gaussians of", name, banner, flush=True)


driver.run(drive)
sys.exit(sys.modules["torch"] is not None)
"""
FACES = """
import enhance, renderer

for face in (enhance, renderer):
    for name in face.__all__:
        getattr(face, name)
model = renderer.DynamicGaussians.load(renderer_model)
camera = renderer.Camera.from_fov(60, 48, 40)
assert renderer.render(model.at(0.5), camera).image.shape == (40, 48, 3)
try:
    renderer.rasterize(*[None] * 5, camera)
except ImportError as error:
    print("no rasterize:", error)
"""


class Machine:
    """One without torch, and a folder on it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        (folder / "hidden").mkdir()
        (folder / "hidden" / "sitecustomize.py").write_text(HIDDEN)

    def python(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        environment = os.environ | {"PYTHONPATH": f"{self._folder / 'hidden'}{os.pathsep}{ROOT}"}
        line = [sys.executable, *arguments]
        return subprocess.run(
            line, cwd=self._folder, env=environment, capture_output=True, text=True, timeout=300
        )

    def vesselsplat(self, line: str) -> subprocess.CompletedProcess[str]:
        return self.python("-m", "app", *line.split())


@pytest.fixture(scope="module")
def empty_machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    machine = Machine(tmp_path_factory.mktemp("without_torch"))
    assert machine.python("-c", "import torch").returncode == 1
    return machine


@pytest.fixture(scope="module")
def machine(empty_machine: Machine) -> Machine:
    """On which the working commands have worked."""
    done = empty_machine.python("-c", IN_ONE_PROCESS, *WORKING.strip().splitlines())
    assert done.returncode == 0, done.stderr[-2000:]
    return empty_machine


@pytest.mark.slow
def test_commands_work_and_lpips_says_why_it_is_missing(machine: Machine) -> None:
    assert NO_TORCH in machine.vesselsplat("info").stdout
    evaluated = machine.vesselsplat("evaluate run")
    assert evaluated.returncode == 0
    assert f"LPIPS: not measured: {NO_TORCH}" in evaluated.stdout


@pytest.mark.slow
def test_a_spawned_process_trains(machine: Machine) -> None:
    done = machine.python("-c", OF_A_SPAWNED_PROCESS)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_the_libraries_offer_all_but_the_differentiable_rasteriser(machine: Machine) -> None:
    path = "from pathlib import Path; renderer_model = Path('run/model.safetensors')\n"
    done = machine.python("-c", path + FACES)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("no rasterize:")


@pytest.mark.slow
@pytest.mark.display
def test_the_window_opens_a_run(empty_machine: Machine, runs: dict[str, Path]) -> None:
    done = empty_machine.python("-c", WINDOW, str(runs["original"]))
    assert done.returncode == 0, done.stderr[-2000:] + done.stdout[-2000:]
    assert "Gaussians of small None" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        "render run --out reference --frames test --with reference",
        "evaluate run --lpips-weights clip",
        "train clip --run card --iterations 4 --device cuda",
    ],
)
def test_where_torch_is_needed_one_line_says_so(machine: Machine, line: str) -> None:
    done = machine.vesselsplat(line)
    assert done.returncode == 2
    assert NO_TORCH in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.fixture
def hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """None in sys.modules is how a module is hidden."""
    monkeypatch.setitem(sys.modules, "torch", None)


@pytest.mark.usefixtures("hidden")
def test_the_report_keeps_the_stability_rows_that_need_no_oracle(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = {
        name: lambda *_: ()
        for name in renderer.measuring.stability.PARTS
        if name not in ("overlap", *BY_TORCH)
    }
    monkeypatch.setattr(renderer.measuring.stability, "PARTS", renderer.measuring.stability.PARTS | slow)
    monkeypatch.setattr(enhance.stability, "PARTS", {})
    section = stability.measure(bench, Clock.of(600))
    assert any(NO_TORCH in line for line in section.not_measured)
    hazards = {row[0] for table in section.tables for row in table.rows}
    assert "overlap" in hazards
    assert "blending (16): image" not in hazards


@pytest.mark.usefixtures("hidden")
def test_the_report_draws_without_an_oracle_what_needs_none(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawing, "schedule", lambda clip: CONFIG)
    section = drawing.measure(bench, Clock.of(600))
    assert any(NO_TORCH in line for line in section.not_measured)
    assert "CPU rasteriser" not in {table.title for table in section.tables}


@pytest.fixture
def bench(clip_path: Path, tmp_path: Path) -> Bench:
    return Bench(clip_path, (), tmp_path, lambda _: None)
