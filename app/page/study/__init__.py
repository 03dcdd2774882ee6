"""What the tabs of studies share: a question, a picture that grows, and the panel beside it."""
