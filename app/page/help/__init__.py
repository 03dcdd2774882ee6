"""View of the tab Help: model, figures, glossary."""
