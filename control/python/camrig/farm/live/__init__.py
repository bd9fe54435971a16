"""One world on many machines, live: every node runs all of it, and shares the log of commands only (docs/farm.md)."""
