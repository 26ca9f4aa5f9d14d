"""What is asked of a model besides a run."""
