"""From a train to the tables of its equations."""
