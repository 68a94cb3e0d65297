"""Tests and benchmarks run as the program does: numba's threads rest while they wait for each other."""

from app.console.startup import rest_while_waiting

rest_while_waiting()
