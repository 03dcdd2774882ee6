"""The two methods whose equations are solved, as the dictionaries that hard.json holds."""


def reference(joint_damping="table", threshold=0.002):
    return {"name": "reference", "joint_damping": joint_damping, "threshold": threshold}


def exact(stiffness, damping):
    """The exact penalty."""
    return {"name": "exact", "stiffness": float(stiffness), "damping": float(damping)}
