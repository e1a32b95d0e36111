within IT2Hysteresis.Interfaces;
partial block PartialChain "Parameters and inputs that plant and inverse have in common"
  parameter IT2Hysteresis.Parameters.Base parameters=IT2Hysteresis.Parameters.Table1()
    "Parameter set, the same for a plant and its inverse"
    annotation (choicesAllMatching=true);
  parameter Boolean useForce=false "= true, if the input force is used, otherwise the force is 0"
    annotation (Evaluate=true, HideResult=true, choices(checkBox=true));
  parameter Boolean useTemperature=false
    "= true, if the input temperature is used, otherwise the temperature is 20 degC"
    annotation (Evaluate=true, HideResult=true, choices(checkBox=true));
  Modelica.Blocks.Interfaces.RealInput force(final quantity="Force", final unit="N", nominal=10) if useForce
    "External force, compressive positive; acts through the load effect, which is off unless parameterised"
    annotation (Placement(transformation(extent={{-20,-20},{20,20}}, rotation=90, origin={-60,-120})));
  Modelica.Blocks.Interfaces.RealInput temperature(
    final quantity="ThermodynamicTemperature",
    final unit="K",
    displayUnit="degC",
    nominal=300) if useTemperature
    "Temperature of the stage; acts through the drift effect, which is off unless parameterised"
    annotation (Placement(transformation(extent={{-20,-20},{20,20}}, rotation=90, origin={60,-120})));
protected
  Modelica.Blocks.Interfaces.RealInput forceInternal(final quantity="Force", final unit="N")
    "Needed to connect to the conditional connector";
  Modelica.Blocks.Interfaces.RealInput temperatureInternal(
    final quantity="ThermodynamicTemperature",
    final unit="K",
    displayUnit="degC")
    "Needed to connect to the conditional connector";
  final parameter Modelica.Units.SI.Voltage playThreshold[parameters.playCount + 1]=
    cat(1, parameters.playThreshold, {0}) "Thresholds r_j; the last is of an operator without weight";
  final parameter Real playWeight[parameters.playCount + 1]=cat(1, parameters.playWeight, {0})
    "Weights w_j; with a neutral element no vector is empty";
  final parameter Real creepGain[parameters.creepCount + 1]=cat(1, parameters.creepGain, {0})
    "Gains c_i; the last term is without gain";
  final parameter Real creepRate[parameters.creepCount + 1]=
    IT2Hysteresis.Functions.Effects.gains(
      parameters.sampleTime,
      cat(1, parameters.creepTimeConstant, {1}))
    "Part of the way that a creep term goes in one tick, g_i";
  final parameter Modelica.Units.SI.Length curve[5]={parameters.nonlinearityQuadratic,parameters.nonlinearityCubic,
    parameters.nonlinearityQuartic,parameters.nonlinearityQuintic,parameters.nonlinearitySextic} "Coefficients of the static curve";
  final parameter Boolean bends=max(abs(curve)) > 0 "= true, if there is a static curve";
  final parameter Modelica.Units.SI.Length curveMin=parameters.displacementZero + parameters.nonlinearityMinimum
    "Lower end of the curve";
  final parameter Modelica.Units.SI.Length curveMax=parameters.displacementZero + parameters.nonlinearityMaximum
    "Upper end of the curve";
  final parameter Modelica.Units.SI.Length straightRest=
    if bends then IT2Hysteresis.Functions.Effects.nonlinearityInverse(
      curve,
      curveMin,
      curveMax,
      parameters.initialDisplacement)
    else parameters.initialDisplacement "Displacement in front of the static curve, at initialDisplacement";
  final parameter Modelica.Units.SI.Length strokeRest=
    (straightRest - parameters.displacementZero - sum(creepGain)*parameters.initialCreep)/(1 + sum(creepGain))
    "Displacement in front of creep, above the sensor's zero, at initialDisplacement";
  final parameter Modelica.Units.SI.Length coreRest=parameters.displacementZero + strokeRest
    "Displacement behind the fuzzy system, at initialDisplacement";
  final parameter Modelica.Units.SI.Length creepRest=strokeRest + parameters.initialCreep
    "Creep states at initialDisplacement";
  final parameter Real lowerEnd[4]=IT2Hysteresis.Functions.linearisation(
    parameters.ruleSigmaLower,
    parameters.ruleSigmaUpper,
    parameters.ruleCentre,
    parameters.ruleQ1,
    parameters.ruleQ2,
    parameters.ruleQ3,
    parameters.displacementMin)
    "Lower end of the fuzzy system's range";
  final parameter Real upperEnd[4]=IT2Hysteresis.Functions.linearisation(
    parameters.ruleSigmaLower,
    parameters.ruleSigmaUpper,
    parameters.ruleCentre,
    parameters.ruleQ1,
    parameters.ruleQ2,
    parameters.ruleQ3,
    parameters.displacementMax)
    "Upper end of the fuzzy system's range";
  constant Real rounding=1e-9 "Share of a range by which a value beyond its end is within: an inverse may aim at the end";
  final parameter Modelica.Units.SI.Voltage voltageMiddle=(parameters.voltageMin + parameters.voltageMax)/2
    "Middle of the range of the voltage";
  final parameter Modelica.Units.SI.Voltage voltageReach=
    (0.5 + rounding)*(parameters.voltageMax - parameters.voltageMin)
    "How far from it the voltage may be";
  final parameter Modelica.Units.SI.Length coreMiddle=
    (parameters.displacementMin + parameters.displacementMax)/2
    "Middle of the range of the fuzzy system";
  final parameter Modelica.Units.SI.Length coreReach=
    (0.5 + rounding)*(parameters.displacementMax - parameters.displacementMin)
    "How far from it the displacement behind the fuzzy system may be";
  final parameter Modelica.Units.SI.Voltage coreInputRest=IT2Hysteresis.Functions.coreInverse(
    parameters.ruleSigmaLower,
    parameters.ruleSigmaUpper,
    parameters.ruleCentre,
    parameters.ruleQ1,
    parameters.ruleQ2,
    parameters.ruleQ3,
    coreRest,
    coreRest,
    lowerEnd,
    upperEnd)
    "Voltage behind the play operators, at rest";
  final parameter Modelica.Units.SI.Voltage playTurned[parameters.playCount + 1]=
    IT2Hysteresis.Functions.Effects.playStates(
      playThreshold,
      fill(parameters.initialDemagnetisation, parameters.playCount + 1),
      parameters.initialDemagnetisation + parameters.initialExcursion)
    "Play operators where the stage turned, before it came to rest";
  final parameter Modelica.Units.SI.Voltage voltageRest=
    IT2Hysteresis.Functions.Effects.playInverse(
      playThreshold,
      playWeight,
      playTurned,
      coreInputRest) "Voltage at rest";
  final parameter Modelica.Units.SI.Voltage playRest[parameters.playCount + 1]=
    IT2Hysteresis.Functions.Effects.playStates(
      playThreshold,
      playTurned,
      voltageRest) "Play operators at rest";
  final parameter Boolean saturates=parameters.saturationMinimum < parameters.saturationMaximum
    "= true, if the amplifier has limits";
  final parameter Boolean slews=parameters.slewRate > 0 "= true, if the amplifier has a slew limit";
  final parameter Modelica.Units.SI.Voltage lowest=
    if saturates then parameters.saturationMinimum else -Modelica.Constants.inf
    "Lowest voltage of the amplifier";
  final parameter Modelica.Units.SI.Voltage highest=
    if saturates then parameters.saturationMaximum else Modelica.Constants.inf
    "Highest voltage of the amplifier";
  final parameter Modelica.Units.SI.Voltage slewStep=
    if slews then parameters.slewRate*parameters.sampleTime else Modelica.Constants.inf
    "Largest change of the amplifier's voltage in one tick";
  final parameter Real lagRate=
    if parameters.lagTimeConstant > 0 then
      IT2Hysteresis.Functions.Effects.gain(parameters.sampleTime, parameters.lagTimeConstant)
    else 1 "Part of the way that the lag goes in one tick, g";
  final parameter Real poles[2]=
    if parameters.resonanceFrequency > 0 then IT2Hysteresis.Functions.Effects.resonancePoles(
      parameters.resonanceFrequency,
      parameters.resonanceDamping,
      parameters.sampleTime)
    else zeros(2) "Coefficients of the resonance; without one it passes its input on";
equation
  connect(force, forceInternal);
  connect(temperature, temperatureInternal);
  if not useForce then
    forceInternal = 0;
  end if;
  if not useTemperature then
    temperatureInternal = 293.15;
  end if;
  annotation (Documentation(info="<html>
<p>
The parameter set, and the two inputs beside the signal path. They are off by default, so that a block without them
needs no connection. Before the first tick the chain is at <code>initialDisplacement</code>, as <a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a> says:
for long if <code>initialCreep</code> is 0, and on the initial loading curve of a new stage if
<code>initialDemagnetisation</code> and <code>initialExcursion</code> are.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PartialChain;
