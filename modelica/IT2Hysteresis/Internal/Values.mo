within IT2Hysteresis.Internal;
record Values "All parameters of a set as one vector"
  extends Modelica.Icons.Record;
  parameter IT2Hysteresis.Parameters.Table1 parameters "Parameter set";
  parameter Modelica.Units.SI.Length initialDisplacement(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=parameters.initialDisplacement
    "Displacement before the first tick, which a block may choose";
  final parameter Real vector[
    43 +
    size(parameters.ruleSigmaLower, 1) +
    size(parameters.ruleSigmaUpper, 1) +
    size(parameters.ruleCentre, 1) +
    size(parameters.ruleQ1, 1) +
    size(parameters.ruleQ2, 1) +
    size(parameters.ruleQ3, 1) +
    size(parameters.playThreshold, 1) +
    size(parameters.playWeight, 1) +
    size(parameters.creepGain, 1) +
    size(parameters.creepTimeConstant, 1)]=
    cat(
      1,
      {parameters.sampleTime,
        initialDisplacement,
        parameters.voltageMin,
        parameters.voltageMax,
        parameters.displacementMin,
        parameters.displacementMax},
      {1.0*size(parameters.ruleSigmaLower, 1)},
      parameters.ruleSigmaLower,
      {1.0*size(parameters.ruleSigmaUpper, 1)},
      parameters.ruleSigmaUpper,
      {1.0*size(parameters.ruleCentre, 1)},
      parameters.ruleCentre,
      {1.0*size(parameters.ruleQ1, 1)},
      parameters.ruleQ1,
      {1.0*size(parameters.ruleQ2, 1)},
      parameters.ruleQ2,
      {1.0*size(parameters.ruleQ3, 1)},
      parameters.ruleQ3,
      {1.0*size(parameters.playThreshold, 1)},
      parameters.playThreshold,
      {1.0*size(parameters.playWeight, 1)},
      parameters.playWeight,
      {1.0*size(parameters.creepGain, 1)},
      parameters.creepGain,
      {1.0*size(parameters.creepTimeConstant, 1)},
      parameters.creepTimeConstant,
      {parameters.delayTime,
        parameters.slewRate,
        parameters.saturationMinimum,
        parameters.saturationMaximum,
        parameters.lagTimeConstant,
        parameters.loadCompliance,
        parameters.resonanceFrequency,
        parameters.resonanceDamping,
        parameters.resonanceSamplingZero,
        parameters.resonanceSamplingDelay,
        parameters.driftTemperatureCoefficient,
        parameters.driftRate,
        parameters.nonlinearityQuadratic,
        parameters.nonlinearityCubic,
        parameters.nonlinearityQuartic,
        parameters.humAmplitude,
        parameters.humFrequency,
        parameters.humPhase,
        parameters.initialDemagnetisation,
        parameters.initialExcursion,
        parameters.initialCreep,
        parameters.nonlinearityMinimum,
        parameters.nonlinearityMaximum,
        parameters.displacementZero,
        parameters.nonlinearityQuintic,
        parameters.nonlinearitySextic,
        parameters.initialCreepAge})
    "Numbers in SI units";
  final parameter Integer needed=
    43 +
    6*size(parameters.ruleSigmaLower, 1) +
    2*size(parameters.playThreshold, 1) +
    2*size(parameters.creepGain, 1)
    "Numbers that there are where vectors that belong together are of one length"
    annotation (Evaluate=true);
  final parameter Real checked[needed]=IT2Hysteresis.Internal.resized(vector, needed)
    "Those that checkBounds reads";
  annotation (
    Documentation(info="<html>
<p>
What the constructors of the external objects take: the parameters in the order of
<a href=\"modelica://IT2Hysteresis.Parameters.Base\">Base</a>, a vector behind the number of its elements.
The C sources read them by the table that this is generated from.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end Values;
