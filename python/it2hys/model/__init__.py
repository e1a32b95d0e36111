"""The model: its variables and parameter sets, its equations in CasADi, and the compiled core."""
