"""One part of the report a file: `measure(bench, clock)` gives its section."""
