"""What belongs to FMI 2.0 alone: its description and its C glue."""
