"""A job that reconstructs a clip and writes its surface."""

from __future__ import annotations

from pathlib import Path

import trimesh

from app.sweeps.jobs import SURFACE, JobFolder, Keeps
from app.sweeps.plan import planned
from app.sweeps.spec import spec_of
from app.sweeps.tasks import carry_out


def test_the_surface_lies_beside_its_measures(clip_path: Path, tmp_path: Path) -> None:
    given = {
        "clips": [str(clip_path)],
        "task": "mesh",
        "settings": {"iterations": 40, "n_gaussians": 600},
        "grid": {"vertices": [200, 800]},
    }
    plan = planned(spec_of(given, path := tmp_path / "sweep.toml"), path)
    assert len({job.key for job in plan.jobs}) == 2
    found = []
    for job in plan.jobs:
        place = JobFolder.of(tmp_path, job.key).path
        place.mkdir(parents=True)
        measures = carry_out(job, plan.clip_of(job), place, Keeps(model=False))
        mesh = trimesh.load_mesh(place / SURFACE)
        assert measures["vertices"] == len(mesh.vertices)
        assert measures["triangles"] == len(mesh.faces)
        assert measures["bytes"] == (place / SURFACE).stat().st_size
        assert 0 < (measures["surface_mm"] or 0) < (measures["surface_95_mm"] or 0) < 20
        found.append(measures["vertices"] or 0)
    assert 2 * found[0] < found[1]
