"""What a path is read as, and what can be done with it, told without doing it: `vesselsplat info PATH`."""
