within IT2Hysteresis.Internal;
block Constants "What follows from a parameter set: constants of the stages, and the chain at rest"
  parameter IT2Hysteresis.Parameters.Table1 parameters "Parameter set";
  parameter Boolean restsAtVoltage=false "= true, if the chain rests at restVoltage, otherwise at restDisplacement"
    annotation (Evaluate=true);
  parameter Modelica.Units.SI.Voltage restVoltage(min=-2000, max=2000)=0 "Voltage at rest";
  parameter Modelica.Units.SI.Length restDisplacement(min=-0.1, max=0.1, displayUnit="um")=
    parameters.initialDisplacement "Displacement at rest";
  final parameter Integer ruleCount=size(parameters.ruleSigmaLower, 1) "Number of rules"
    annotation (Evaluate=true);
  final parameter Integer playCount=size(parameters.playThreshold, 1) "Number of play operators"
    annotation (Evaluate=true);
  final parameter Integer creepCount=size(parameters.creepGain, 1) "Number of creep terms"
    annotation (Evaluate=true);
  final parameter Integer rules=max(1, ruleCount) "Length of the vectors of the rules: none is empty"
    annotation (Evaluate=true);
  final parameter Modelica.Units.SI.Length ruleSigmaLower[rules]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.ruleSigmaLower, {1}), rules) "Deviations of the lower memberships";
  final parameter Modelica.Units.SI.Length ruleSigmaUpper[rules]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.ruleSigmaUpper, {1}), rules) "Deviations of the upper memberships";
  final parameter Modelica.Units.SI.Length ruleCentre[rules]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.ruleCentre, {0}), rules) "Centres";
  final parameter Real ruleQ1[rules]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.ruleQ1, {0}), rules) "Coefficients q_l1";
  final parameter Real ruleQ2[rules]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.ruleQ2, {0}), rules) "Coefficients q_l2";
  final parameter Modelica.Units.SI.Length ruleQ3[rules]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.ruleQ3, {0}), rules) "Constants q_l3";
  final parameter Boolean defined=parameters.sampleTime > 0
    and min(cat(1, parameters.ruleSigmaLower, {1})) > 0 and min(cat(1, parameters.ruleSigmaUpper, {1})) > 0
    and min(cat(1, parameters.creepTimeConstant, {1})) > 0 and abs(parameters.resonanceDamping) <= 1 and parameters.resonanceSamplingZero <= 0 and (not bends or curveMin < curveMax)
    "= true, if the constants can be computed; otherwise they are 0, and the block says what is wrong";
  final parameter Modelica.Units.SI.Voltage playThreshold[playCount + 1]=
    cat(1, parameters.playThreshold, {0}) "Thresholds r_j; the last is of an operator without weight";
  final parameter Real playWeight[playCount + 1]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.playWeight, {0}), playCount + 1)
    "Weights w_j; with a neutral element no vector is empty";
  final parameter Real creepGain[creepCount + 1]=cat(1, parameters.creepGain, {0})
    "Gains c_i; the last term is without gain";
  final parameter Modelica.Units.SI.Time creepTimeConstant[creepCount + 1]=
    IT2Hysteresis.Internal.resized(cat(1, parameters.creepTimeConstant, {1}), creepCount + 1)
    "Time constants of the terms";
  final parameter Real creepRate[creepCount + 1]=
    if defined then IT2Hysteresis.Functions.Effects.gains(parameters.sampleTime, creepTimeConstant)
    else zeros(creepCount + 1)
    "Part of the way that a creep term goes in one tick, g_i";
  final parameter Modelica.Units.SI.Length curve[5]={parameters.nonlinearityQuadratic,parameters.nonlinearityCubic,
    parameters.nonlinearityQuartic,parameters.nonlinearityQuintic,parameters.nonlinearitySextic} "Coefficients of the static curve";
  final parameter Boolean bends=max(abs(curve)) > 0 "= true, if there is a static curve";
  final parameter Modelica.Units.SI.Length curveMin=parameters.displacementZero + parameters.nonlinearityMinimum
    "Lower end of the curve";
  final parameter Modelica.Units.SI.Length curveMax=parameters.displacementZero + parameters.nonlinearityMaximum
    "Upper end of the curve";
  final parameter Real lowerEnd[4]=
    if defined then IT2Hysteresis.Functions.linearisation(
      ruleSigmaLower,
      ruleSigmaUpper,
      ruleCentre,
      ruleQ1,
      ruleQ2,
      ruleQ3,
      parameters.displacementMin) else zeros(4)
    "Lower end of the fuzzy system's range";
  final parameter Real upperEnd[4]=
    if defined then IT2Hysteresis.Functions.linearisation(
      ruleSigmaLower,
      ruleSigmaUpper,
      ruleCentre,
      ruleQ1,
      ruleQ2,
      ruleQ3,
      parameters.displacementMax) else zeros(4)
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
  final parameter Modelica.Units.SI.Voltage playTurned[playCount + 1]=
    IT2Hysteresis.Functions.Effects.playStates(
      playThreshold,
      fill(parameters.initialDemagnetisation, playCount + 1),
      parameters.initialDemagnetisation + parameters.initialExcursion)
    "Play operators where the stage turned, before it came to rest";
  final parameter Modelica.Units.SI.Length creepAhead[creepCount + 1]=
    if defined then parameters.initialCreep*exp(-parameters.initialCreepAge ./ creepTimeConstant)
    else fill(0, creepCount + 1)
    "How far the creep states lie above what they creep to, at the start";
  final parameter Modelica.Units.SI.Length creepShare=sum(creepGain .* creepAhead)
    "What that adds to the displacement";
  final parameter Modelica.Units.SI.Length straightRest=
    if not defined then 0
    elseif restsAtVoltage then parameters.displacementZero + (1 + sum(creepGain))*(
      IT2Hysteresis.Functions.coreRest(
        ruleSigmaLower,
        ruleSigmaUpper,
        ruleCentre,
        ruleQ1,
        ruleQ2,
        ruleQ3,
        restVoltage + sum(playWeight .* IT2Hysteresis.Functions.Effects.playStates(
          playThreshold,
          playTurned,
          restVoltage)),
        lowerEnd,
        upperEnd) - parameters.displacementZero) + creepShare
    elseif bends then IT2Hysteresis.Functions.Effects.nonlinearityInverse(
      curve,
      curveMin,
      curveMax,
      restDisplacement)
    else restDisplacement "Displacement in front of the static curve, at rest";
  final parameter Modelica.Units.SI.Length displacementRest=
    if restsAtVoltage and bends then IT2Hysteresis.Functions.Effects.nonlinearity(
      curve,
      curveMin,
      curveMax,
      straightRest)
    elseif restsAtVoltage then straightRest
    else restDisplacement "Displacement at rest";
  final parameter Modelica.Units.SI.Length strokeRest=
    (straightRest - parameters.displacementZero - creepShare)/(1 + sum(creepGain))
    "Displacement in front of creep, above the sensor's zero, at rest";
  final parameter Modelica.Units.SI.Length coreRest=parameters.displacementZero + strokeRest
    "Displacement behind the fuzzy system, at rest";
  final parameter Modelica.Units.SI.Length creepRest[creepCount + 1]=
    fill(strokeRest, creepCount + 1) + creepAhead "Creep states at rest";
  final parameter Modelica.Units.SI.Voltage voltageRest=
    if restsAtVoltage then restVoltage
    elseif not defined then 0
    else IT2Hysteresis.Functions.Effects.playInverse(
      playThreshold,
      playWeight,
      playTurned,
      IT2Hysteresis.Functions.coreInverse(
        ruleSigmaLower,
        ruleSigmaUpper,
        ruleCentre,
        ruleQ1,
        ruleQ2,
        ruleQ3,
        coreRest,
        coreRest,
        lowerEnd,
        upperEnd)) "Voltage at rest";
  final parameter Modelica.Units.SI.Voltage playRest[playCount + 1]=
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
    if defined and parameters.lagTimeConstant > 0 then
      IT2Hysteresis.Functions.Effects.gain(parameters.sampleTime, parameters.lagTimeConstant)
    else 1 "Part of the way that the lag goes in one tick, g";
  final parameter Real ringing[4]=
    if defined and parameters.resonanceFrequency > 0 then IT2Hysteresis.Functions.Effects.resonanceCoefficients(
      parameters.resonanceFrequency,
      parameters.resonanceDamping,
      parameters.resonanceSamplingZero,
      parameters.sampleTime)
    else {0,0,1,0} "Coefficients of the resonance; without one it passes its input on";
  final parameter Modelica.Units.SI.Time resonanceDelay=
    if defined and parameters.resonanceFrequency > 0 then parameters.resonanceSamplingDelay else 0
    "Delay that goes with the resonance";
  final parameter Real resonanceTicks=if defined then min(resonanceDelay/parameters.sampleTime, 2) else 0
    "The same in ticks";
  annotation (Documentation(info="<html>
<p>
The constants of the chain's <a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">effects</a>, and the states that hold the chain
where it rests before the first tick: at a displacement, or at a voltage.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Constants;
