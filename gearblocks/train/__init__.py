"""What a train is: components, connections, paths, values."""
