"""The solver core in C, its methods, and how Python calls it."""
