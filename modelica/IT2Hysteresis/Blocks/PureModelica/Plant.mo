within IT2Hysteresis.Blocks.PureModelica;
block Plant "Actuator with hysteresis: from voltage to displacement"
  extends IT2Hysteresis.Interfaces.PartialPlant;
protected
  constant Integer longestDelay=64 "In ticks";
  final parameter Integer delayTicks=integer(parameters.delayTime/parameters.sampleTime + 1e-9)
    "Whole ticks of the delay; a rounding error is none";
  final parameter Real delayFraction=max(0, parameters.delayTime/parameters.sampleTime - delayTicks)
    "Fraction of a tick beyond them";
  discrete Modelica.Units.SI.Voltage past[longestDelay + 1](
    each start=voltageRest,
    each fixed=true) "Voltages at the ticks before";
  discrete Modelica.Units.SI.Voltage delayed(start=voltageRest, fixed=true) "Behind the delay";
  discrete Modelica.Units.SI.Voltage slewed(start=voltageRest, fixed=true) "Behind the slew limit";
  discrete Modelica.Units.SI.Voltage limited(start=voltageRest, fixed=true) "Behind the saturation";
  discrete Modelica.Units.SI.Voltage lagged(start=voltageRest, fixed=true) "Behind the lag";
  discrete Modelica.Units.SI.Voltage p[parameters.playCount + 1](
    start=playRest,
    each fixed=true) "Play operators";
  discrete Modelica.Units.SI.Length core(start=coreRest, fixed=true) "Behind the fuzzy system, y_k of (10)";
  discrete Modelica.Units.SI.Length loaded(start=coreRest, fixed=true) "Behind the load";
  discrete Modelica.Units.SI.Length s[parameters.creepCount + 1](
    each start=creepRest,
    each fixed=true) "Creep states";
  discrete Modelica.Units.SI.Length crept(start=straightRest, fixed=true) "Behind creep";
  discrete Modelica.Units.SI.Length resonated(start=straightRest, fixed=true) "Behind the resonance";
  discrete Modelica.Units.SI.Length resonatedBefore(start=straightRest, fixed=true)
    "The same at the tick before";
  discrete Modelica.Units.SI.Length straight(start=straightRest, fixed=true) "Behind the drift";
  discrete Boolean left(start=false, fixed=true) "The range that the parameters are valid for was left";
equation
  assert(delayTicks <= longestDelay, "delayTime must be at most 64 sample times.");
  when sample(0, parameters.sampleTime) then
    delayed = IT2Hysteresis.Functions.Effects.delayed(pre(past), voltage, delayTicks, delayFraction);
    past = IT2Hysteresis.Functions.Effects.delayedStates(pre(past), voltage);
    slewed = IT2Hysteresis.Functions.Effects.slew(slewStep, pre(slewed), delayed);
    limited = IT2Hysteresis.Functions.Effects.saturation(lowest, highest, slewed);
    lagged = IT2Hysteresis.Functions.Effects.lag(lagRate, pre(lagged), limited);
    p = IT2Hysteresis.Functions.Effects.playStates(playThreshold, pre(p), lagged);
    core = IT2Hysteresis.Functions.core(
      parameters.ruleSigmaLower,
      parameters.ruleSigmaUpper,
      parameters.ruleCentre,
      parameters.ruleQ1,
      parameters.ruleQ2,
      parameters.ruleQ3,
      pre(core),
      IT2Hysteresis.Functions.Effects.play(playWeight, p, lagged),
      lowerEnd,
      upperEnd);
    loaded = IT2Hysteresis.Functions.Effects.load(parameters.loadCompliance, core, forceInternal);
    s = IT2Hysteresis.Functions.Effects.creepStates(
      creepRate,
      pre(s),
      loaded - parameters.displacementZero);
    crept = parameters.displacementZero + IT2Hysteresis.Functions.Effects.creep(
      creepGain,
      s,
      loaded - parameters.displacementZero);
    resonated = IT2Hysteresis.Functions.Effects.resonance(
      poles,
      pre(resonated),
      pre(resonatedBefore),
      crept);
    resonatedBefore = pre(resonated);
    straight = resonated + IT2Hysteresis.Functions.Effects.drift(
      parameters.driftTemperatureCoefficient,
      parameters.driftRate,
      temperatureInternal,
      time);
    displacement = if bends then IT2Hysteresis.Functions.Effects.nonlinearity(
      curve,
      curveMin,
      curveMax,
      straight) else straight;
    measured = displacement + IT2Hysteresis.Functions.Effects.hum(
      parameters.humAmplitude,
      parameters.humFrequency,
      parameters.humPhase,
      time);
    outOfRange = abs(voltage - voltageMiddle) > voltageReach or abs(core - coreMiddle) > coreReach;
    left = pre(left) or outOfRange;
    assert(pre(left) or not left,
      "The voltage left voltageMin .. voltageMax, or the displacement displacementMin .. displacementMax, "
      + "the range that the parameters are valid for; beyond it the model is extrapolated. This is said once.",
      AssertionLevel.warning);
  end when;
  annotation (defaultComponentName="plant", Documentation(info="<html>
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
