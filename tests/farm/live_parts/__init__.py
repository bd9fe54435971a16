"""Farms, their readers and what is done to them: for tests/farm/live.py."""
