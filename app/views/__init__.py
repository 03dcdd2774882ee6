"""The figures, one a file: each is built once per session, then its sources are written in place."""
