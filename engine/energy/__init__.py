"""The energy balance of a response."""
