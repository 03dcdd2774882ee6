"""The tab Paper: the paper's claims as cards, each checked when it comes into view."""
