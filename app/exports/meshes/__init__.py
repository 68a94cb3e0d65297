"""The tissue surface as files: `film` its way through the clip, and one format a file."""
