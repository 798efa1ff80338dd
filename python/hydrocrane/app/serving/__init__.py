"""Servers: the page of the cockpit and the bridge to other programs."""
