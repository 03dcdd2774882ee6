"""View The paper's claims, of the tab Help: the paper's claims as cards, each checked when it comes into view."""
