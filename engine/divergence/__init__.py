"""The difference between a penalty solution and the reference: its size, its parts, its cause and what to change."""
