"""A training step's pictures through torch and gsplat: imported only by a process that trains on a card."""
