"""Parts that the tabs of studies share: a question, a picture that refines, and the panel beside it."""
