"""Time stepping, step by step: one-step methods with whole steps or steps cut at contact changes, and their laws."""
