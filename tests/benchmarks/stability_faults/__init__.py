"""Deliberate faults in the kernels, against the rows of the stability table that notice them."""
