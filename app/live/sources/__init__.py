"""Where live pictures come from, one kind a file."""
