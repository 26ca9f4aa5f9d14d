"""From a train to the tables of its equations: rigid constraints, kinematics, coordinates. Knows nothing of C."""
