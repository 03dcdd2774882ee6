"""The head of the page: title, question, tabs, take-away menu, theme, tour, errors and the summary."""
