"""From the tables to C."""
