"""Sweeps: many clips and settings, each pair a job, on this machine or a cluster.

`spec` says what is asked for, `tasks` what is done in one job, `engines` where, `sweep` runs them all, and
`table`, `summary` and `page` tell what came of it.
"""
