"""Reconstruction and drawing. Importing it imports neither torch nor OpenGL."""

import os

# numba's OpenMP threads spin while they wait for each other. Where anything else runs on the same
# cores, such as the window beside a training job, each wait then costs a whole time slice: a training
# step takes four times as long. The runtime reads this once, when numba first starts its threads.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
