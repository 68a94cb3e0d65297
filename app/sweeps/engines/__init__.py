"""Where the jobs of a sweep run: each module opens an executor as of `concurrent.futures`, and no more."""
