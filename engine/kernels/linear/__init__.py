"""Linear motions in closed form: matrices, tables, the first root with its certificate."""
