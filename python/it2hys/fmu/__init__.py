"""What is inside an FMU, and the SSP systems that connect FMUs."""
