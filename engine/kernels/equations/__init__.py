"""The equations of motion and the contact law: the only place that has them."""
