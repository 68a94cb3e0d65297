"""Selecting and removing Gaussians of a dynamic model: values and pure functions, all times at once."""
