"""The Jacobian of implicit methods: entries, their expressions and their pattern. Knows nothing of compilers, nor of solvers."""
