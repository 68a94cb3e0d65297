"""A campaign of damaged files, kills and full disks: `python -m tests.benchmarks.attack [--short]`."""
