"""From a train to a model that runs."""
