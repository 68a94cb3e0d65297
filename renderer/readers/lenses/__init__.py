"""Calibrations of lenses, as different programs write them, and images straightened by them."""
