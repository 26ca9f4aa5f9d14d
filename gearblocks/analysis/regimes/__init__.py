"""What kind of motion a driven train answers with: orbits, multipliers, exponents, labels with their evidence."""
