"""What ground truth costs: CPU time of the rig per picture while nobody asks for it, and when somebody does."""
