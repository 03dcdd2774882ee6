"""Worker threads, caches, settings, logs and metrics of one process."""
