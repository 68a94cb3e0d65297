from __future__ import annotations

import numpy as np
import pytest

from enhance.brightness import brighten
from enhance.vessel_curves import DIM, LOWEST, brightness, powers


@pytest.mark.parametrize("z", [0.0, 0.1, 0.35, 0.7, 1.0])
def test_brightness_is_that_of_the_formula(z: float) -> None:
    logs = np.linspace(LOWEST, 0, 3001)
    value = np.polyval(brightness(z).astype(np.float64), 1 - 2 * logs / LOWEST)
    assert 255 * np.abs(value - brighten(2.0**logs, z)).max() < 0.01


@pytest.mark.parametrize("gamma", [0.5, 0.8, 1.05, 1.5, 2.0])
def test_powers_are_powers(gamma: float) -> None:
    values = np.linspace(DIM, 1, 2001)
    found = np.polyval(powers(gamma).astype(np.float64), 2 * (values - DIM) / (1 - DIM) - 1)
    assert 255 * np.abs(found - values**gamma).max() < 0.002
