"""Parameter sets for other tools: a Modelica record, a C header."""
