"""FMUs run: instances, many stepped by compiled code, whole systems simulated."""
