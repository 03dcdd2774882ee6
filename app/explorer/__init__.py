"""State, computing and presenting of one setting; no page import."""
