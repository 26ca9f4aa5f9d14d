"""Checks of FMUs: the archive, the file, the life of an instance, the replay against the in-process run."""
