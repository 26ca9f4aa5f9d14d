"""The Jacobian of implicit methods: entries, their expressions and their pattern."""
