"""Piezo hysteresis: an interval type-2 fuzzy model and its closed-form inverse, as FMUs.

Data flow one way: records (`records`) are identified (`identification`) to a parameter set
(`parameters`), which is packaged as FMUs (`packaging`) and run in co-simulation (`simulation`).
"""
