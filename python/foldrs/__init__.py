"""Which garment is it, where is it folded, and where to grasp it."""
