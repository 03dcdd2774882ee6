"""The head of the page: title, tabs, take-away menu, theme, tour, errors and the summary."""
