within IT2Hysteresis.Internal;
record Values "All parameters of a set as one vector"
  extends Modelica.Icons.Record;
  parameter IT2Hysteresis.Parameters.Base parameters=IT2Hysteresis.Parameters.Table1()
    "Parameter set";
  parameter Modelica.Units.SI.Length initialDisplacement(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=parameters.initialDisplacement
    "Displacement before the first tick, which a block may choose";
  final parameter Real vector[34 + 6*parameters.ruleCount + 2*parameters.playCount + 2*parameters.creepCount]=
    cat(
      1,
      {parameters.sampleTime,
        initialDisplacement,
        parameters.voltageMin,
        parameters.voltageMax,
        parameters.displacementMin,
        parameters.displacementMax,
        1.0*parameters.ruleCount},
      parameters.ruleSigmaLower,
      parameters.ruleSigmaUpper,
      parameters.ruleCentre,
      parameters.ruleQ1,
      parameters.ruleQ2,
      parameters.ruleQ3,
      {1.0*parameters.playCount},
      parameters.playThreshold,
      parameters.playWeight,
      {1.0*parameters.creepCount},
      parameters.creepGain,
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
        parameters.nonlinearitySextic})
    "Numbers in SI units";
  annotation (
    Documentation(info="<html>
<p>
What the constructors of the external objects take: the parameters in the order of
<a href=\"modelica://IT2Hysteresis.Parameters.Base\">Base</a>, vectors behind the number of their elements.
The C sources read them by the table that this is generated from.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end Values;
