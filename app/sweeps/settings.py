"""Settings of a job by the names of the commands' flags, checked by the same types as these."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final, Literal

from pydantic import ValidationError

from app.console.flags import AUTO, meant, problem, shortened
from app.enhancement.methods import METHODS, PAPER, VESSEL, EnhancementSettings, Params
from app.enhancement.settable import PIXELS, SCOPES, Pixels, Scope
from app.errors import UserError
from app.exports.records import LEAST_FACES, MOST_COARSE, MOST_FINE
from app.files.provenance import plain
from app.runs.train_run import PRESETS
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.surface.fineness import VERTICES
from renderer.train.config import TrainConfig

TaskName = Literal["enhance", "train", "mesh"]
READ: Final = ("deinterlacing", "stereo")
PARAMS: Final[Mapping[str, type[EnhancementSettings]]] = {PAPER: EnhanceParams, VESSEL: VesselParams}


@dataclass(frozen=True)
class Enhancing:
    """As of `vesselsplat enhance`."""

    method: str
    params: Params
    pixels: Pixels
    statistics: Scope = SCOPES[0]
    options: ClipOptions = DEFAULTS
    """How videos are read: READ of them."""

    def told(self) -> dict[str, Any]:
        """Every setting by its name, as JSON has it."""
        read = {name: getattr(self.options, name) for name in READ}
        own = {"method": self.method, "pixels": self.pixels, "statistics": self.statistics} | read
        return own | (plain(self.params) if self.params else {})


@dataclass(frozen=True)
class Training:
    """As of `vesselsplat train`, followed by `evaluate`."""

    config: TrainConfig
    input: Literal["original", "enhanced"]
    params: EnhancementSettings | None
    """Of enhanced frames."""
    preset: str | None
    options: ClipOptions

    def told(self) -> dict[str, Any]:
        """Every setting by its name, as JSON has it."""
        enhanced = {"preset": self.preset} if self.preset else {}
        return {**plain(self.config), "input": self.input, **enhanced, **plain(self.options)}


@dataclass(frozen=True)
class Meshing:
    """As of `vesselsplat train`, followed by `export --mesh`."""

    training: Training
    vertices: int
    faces: int | None

    def told(self) -> dict[str, Any]:
        """Every setting by its name, as JSON has it."""
        return self.training.told() | {"vertices": self.vertices, "faces": self.faces}


Settings = Enhancing | Training | Meshing


def training_of(settings: Settings) -> Training | None:
    """Also of a surface; None of what is enhanced."""
    if isinstance(settings, Meshing):
        return settings.training
    return settings if isinstance(settings, Training) else None


def settings_of(task: TaskName, given: Mapping[str, Any]) -> Settings:
    """Raises UserError: a name that the task does not know, or a value out of its range."""
    if task == "enhance":
        return _enhancing(dict(given))
    return _meshing(dict(given)) if task == "mesh" else _training(dict(given))


def _meshing(given: dict[str, Any]) -> Meshing:
    vertices = _whole("vertices", given.pop("vertices", VERTICES), MOST_COARSE, MOST_FINE)
    wanted = given.pop("faces", AUTO)
    faces = None if wanted == AUTO else _whole("faces", wanted, LEAST_FACES, 2 * MOST_FINE)
    return Meshing(_training(given), vertices, faces)


def _whole(name: str, value: object, least: int, most: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise UserError(f"{name}: expected a whole number from {least} to {most}, got {shortened(value)}")
    return value


def _enhancing(given: dict[str, Any]) -> Enhancing:
    method = _chosen("method", given.pop("method", PAPER), METHODS)
    pixels = _chosen("pixels", given.pop("pixels", PIXELS[0]), PIXELS)
    statistics = _chosen("statistics", given.pop("statistics", SCOPES[0]), SCOPES)
    options = _made(ClipOptions, {name: given.pop(name) for name in READ if name in given})
    kind = PARAMS.get(method)
    known = {field.name for field in fields(kind)} if kind else set()
    _require_known(given, {*known, "method", "pixels", "statistics", *READ}, f"method {method}")
    return Enhancing(method, _made(kind, given) if kind else None, pixels, statistics, options)


def _training(given: dict[str, Any]) -> Training:
    input_kind = _chosen("input", given.pop("input", "original"), ("original", "enhanced"))
    if "preset" in given and input_kind != "enhanced":
        raise UserError('preset: has no effect with input = "original"')
    preset = (
        _chosen("preset", given.pop("preset", PAPER), tuple(PRESETS)) if input_kind == "enhanced" else None
    )
    configured = {field.name for field in fields(TrainConfig)} - {"checkpoint_every"}
    reading = {field.name for field in fields(ClipOptions)}
    _require_known(given, {*configured, *reading, "input", "preset"}, "a training")
    return Training(
        _made(TrainConfig, {name: value for name, value in given.items() if name in configured}),
        input_kind,
        PRESETS[preset] if preset else None,
        preset,
        _made(ClipOptions, {name: value for name, value in given.items() if name in reading}),
    )


def _chosen(name: str, value: object, words: tuple[Any, ...]) -> Any:
    if value not in words:
        raise UserError(f"{name}: expected one of {', '.join(words)}, got {shortened(value)}")
    return value


def _require_known(given: Mapping[str, Any], known: set[str], of: str) -> None:
    for name in given:
        if name not in known:
            raise UserError(f"{of}: expected settings among {', '.join(sorted(known))}, got {name!r}")


def _made(kind: Any, given: Mapping[str, Any]) -> Any:
    try:
        return kind(**{name: _several(meant(kind, name, value)) for name, value in given.items()})
    except ValidationError as error:
        raise UserError(problem(error)) from error


def _several(value: object) -> object:
    """A list of TOML as the settings have it."""
    return tuple(value) if isinstance(value, list) else value
