"""What a train is: components, connections, paths, values. Knows nothing of laws."""
