"""Where a penalty solution leaves the reference, why, and what to change first."""
