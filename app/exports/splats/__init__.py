"""A model at one moment as a file of splats, and through time as USD: one format a file."""
