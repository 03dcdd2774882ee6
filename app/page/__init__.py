"""The page: one browser session, its tabs, and the figures and components that they share."""
