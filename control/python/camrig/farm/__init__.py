"""camrig on many machines: `camrig farm`."""
