"""What the outdoor scenes are built of: ground, facades, trees, street furniture, vehicles."""
