within IT2Hysteresis.Blocks.PureModelica;
block Plant "Actuator with hysteresis: from voltage to displacement"
  extends IT2Hysteresis.Interfaces.PartialPlant;
protected
  IT2Hysteresis.Internal.Values all(parameters=parameters, initialDisplacement=initialDisplacement)
    "What is held to its bounds";
  final parameter Real leastSlope[2]=
    if chain.defined then IT2Hysteresis.Functions.leastSlope(
      chain.ruleSigmaLower,
      chain.ruleSigmaUpper,
      chain.ruleCentre,
      chain.ruleQ2,
      parameters.displacementMin,
      parameters.displacementMax) else {1,0} "Can the fuzzy system be inverted?";
  final parameter Real contraction[2]=
    if chain.defined then IT2Hysteresis.Functions.contraction(
      chain.ruleSigmaLower,
      chain.ruleSigmaUpper,
      chain.ruleCentre,
      chain.ruleQ1,
      chain.ruleQ2,
      chain.ruleQ3,
      parameters.displacementMin,
      parameters.displacementMax) else {0,0} "Does it contract?";
  constant Integer longestDelay=64 "In ticks";
  final parameter Integer delayTicks=
    integer(min(parameters.delayTime/parameters.sampleTime, longestDelay) + 1e-9)
    "Whole ticks of the delay; a rounding error is none"
    annotation (Evaluate=true);
  final parameter Real delayFraction=max(0, parameters.delayTime/parameters.sampleTime - delayTicks)
    "Fraction of a tick beyond them";
  discrete Modelica.Units.SI.Voltage past[delayTicks + 1](
    each start=chain.voltageRest,
    each fixed=true) "Voltages at the ticks before";
  discrete Modelica.Units.SI.Voltage delayed(start=chain.voltageRest, fixed=true) "Behind the delay";
  discrete Modelica.Units.SI.Voltage slewed(start=chain.voltageRest, fixed=true) "Behind the slew limit";
  discrete Modelica.Units.SI.Voltage limited(start=chain.voltageRest, fixed=true) "Behind the saturation";
  discrete Modelica.Units.SI.Voltage lagged(start=chain.voltageRest, fixed=true) "Behind the lag";
  discrete Modelica.Units.SI.Voltage p[chain.playCount + 1](
    start=chain.playRest,
    each fixed=true) "Play operators";
  discrete Modelica.Units.SI.Length core(start=chain.coreRest, fixed=true) "Behind the fuzzy system, y_k of (10)";
  discrete Modelica.Units.SI.Length loaded(start=chain.coreRest, fixed=true) "Behind the load";
  discrete Modelica.Units.SI.Length s[chain.creepCount + 1](
    start=chain.creepRest,
    each fixed=true) "Creep states";
  discrete Modelica.Units.SI.Length crept(start=chain.straightRest, fixed=true) "Behind creep";
  discrete Modelica.Units.SI.Length resonated(start=chain.straightRest, fixed=true) "Behind the resonance";
  discrete Modelica.Units.SI.Length resonatedBefore(start=chain.straightRest, fixed=true)
    "The same at the tick before";
  discrete Modelica.Units.SI.Length resonatedLater(start=chain.straightRest, fixed=true)
    "The same behind the delay that goes with the resonance";
  discrete Modelica.Units.SI.Length straight(start=chain.straightRest, fixed=true) "Behind the drift";
  discrete Boolean left(start=false, fixed=true) "The range that the parameters are valid for was left";
initial algorithm
  IT2Hysteresis.Internal.checkBounds(
    getInstanceName(),
    all.checked,
    chain.ruleCount,
    chain.playCount,
    chain.creepCount);
  IT2Hysteresis.Functions.check(
    getInstanceName(),
    parameters.sampleTime,
    parameters.voltageMin,
    parameters.voltageMax,
    parameters.displacementMin,
    parameters.displacementMax,
    chain.ruleSigmaLower,
    chain.ruleSigmaUpper,
    leastSlope,
    contraction,
    chain.playCount,
    chain.playThreshold,
    chain.playWeight,
    chain.creepCount,
    chain.creepGain,
    chain.creepTimeConstant,
    parameters.delayTime,
    parameters.saturationMinimum,
    parameters.saturationMaximum,
    parameters.lagTimeConstant,
    parameters.resonanceFrequency,
    parameters.resonanceDamping,
    parameters.resonanceSamplingZero,
    parameters.resonanceSamplingDelay,
    chain.curve,
    parameters.nonlinearityMinimum,
    parameters.nonlinearityMaximum,
    parameters.humAmplitude,
    parameters.humFrequency,
    initialDisplacement,
    chain.coreRest);
equation
  when sample(0, parameters.sampleTime) then
    assert(abs(voltage) < Modelica.Constants.inf,
      getInstanceName() + ": voltage must be a finite number, not " + String(voltage) + ".");
    delayed = IT2Hysteresis.Functions.Effects.delayed(pre(past), voltage, delayTicks, delayFraction);
    past = IT2Hysteresis.Functions.Effects.delayedStates(pre(past), voltage);
    slewed = IT2Hysteresis.Functions.Effects.slew(chain.slewStep, pre(slewed), delayed);
    limited = IT2Hysteresis.Functions.Effects.saturation(chain.lowest, chain.highest, slewed);
    lagged = IT2Hysteresis.Functions.Effects.lag(chain.lagRate, pre(lagged), limited);
    p = if chain.playCount > 0 then IT2Hysteresis.Functions.Effects.playStates(
      chain.playThreshold,
      pre(p),
      lagged) else pre(p);
    core = IT2Hysteresis.Functions.core(
      chain.ruleSigmaLower,
      chain.ruleSigmaUpper,
      chain.ruleCentre,
      chain.ruleQ1,
      chain.ruleQ2,
      chain.ruleQ3,
      pre(core),
      if chain.playCount > 0 then IT2Hysteresis.Functions.Effects.play(chain.playWeight, p, lagged) else lagged,
      chain.lowerEnd,
      chain.upperEnd);
    loaded = IT2Hysteresis.Functions.Effects.load(parameters.loadCompliance, core, forceInternal);
    s = if chain.creepCount > 0 then IT2Hysteresis.Functions.Effects.creepStates(
      chain.creepRate,
      pre(s),
      loaded - parameters.displacementZero) else pre(s);
    crept = if chain.creepCount > 0 then parameters.displacementZero + IT2Hysteresis.Functions.Effects.creep(
      chain.creepGain,
      s,
      loaded - parameters.displacementZero) else loaded;
    resonated = if parameters.resonanceFrequency > 0 then IT2Hysteresis.Functions.Effects.resonance(
      chain.ringing,
      pre(resonated),
      pre(resonatedBefore),
      pre(crept),
      crept) else crept;
    resonatedBefore = pre(resonated);
    resonatedLater = if chain.resonanceTicks > 0 then IT2Hysteresis.Functions.Effects.resonanceDelayed(
      chain.resonanceTicks,
      resonated,
      pre(resonated),
      pre(resonatedBefore)) else resonated;
    straight = resonatedLater + IT2Hysteresis.Functions.Effects.drift(
      parameters.driftTemperatureCoefficient,
      parameters.driftRate,
      temperatureInternal,
      time);
    displacement = if chain.bends then IT2Hysteresis.Functions.Effects.nonlinearity(
      chain.curve,
      chain.curveMin,
      chain.curveMax,
      straight) else straight;
    measured = displacement + IT2Hysteresis.Functions.Effects.hum(
      parameters.humAmplitude,
      parameters.humFrequency,
      parameters.humPhase,
      time);
    outOfRange = abs(voltage - chain.voltageMiddle) > chain.voltageReach
      or abs(core - chain.coreMiddle) > chain.coreReach;
    left = pre(left) or outOfRange;
    assert(pre(left) or not left,
      getInstanceName() + ": the voltage left voltageMin..voltageMax, or the displacement displacementMin..displacementMax, "
      + "the range that the parameters are valid for; beyond it the model is extrapolated. This is said once.",
      AssertionLevel.warning);
  end when;
  annotation (
    defaultComponentName="plant",
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Text(
          extent={{4,-60},{96,-96}},
          textString="pure",
          textColor={128,128,128})}),
    Documentation(info="<html>
<p>
At every tick t<sub>k</sub> = k <code>parameters.sampleTime</code> the voltage walks along the
<a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">chain</a>: through the effects in front of the fuzzy system, through the
fuzzy system itself, (10), by <a href=\"modelica://IT2Hysteresis.Functions.core\">core</a>, and through the effects behind it. Every stage is a
function of <a href=\"modelica://IT2Hysteresis.Functions.Effects\">Effects</a>. Those that the parameter set does not have
pass their input on.
</p>
<p>
Leaving the range that the parameters are valid for is a warning, which is given once; <code>outOfRange</code> is true as
long as it is left.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Plant;
