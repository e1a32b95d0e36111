"""Scenarios that identify, diagnose and track on the simulated test stand."""
