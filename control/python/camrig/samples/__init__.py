"""Programs that use a rig as any other program would, and judge what they do by its truth."""
