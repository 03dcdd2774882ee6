"""Parts that all tabs use: figures, axis ranges, muting, and components that run in the browser."""
