"""Masks of data sets: what their values mean, and whether they can mean it."""
