within IT2Hysteresis.Blocks.PureModelica;
block Inverse "Feedforward by the closed-form inverse: from desired displacement to voltage"
  extends IT2Hysteresis.Interfaces.PartialInverse;
protected
  constant Modelica.Units.SI.Voltage negligible=1e-9 "The amplifier's limits are said to act above it";
  discrete Modelica.Units.SI.Length resonated(start=parameters.initialDisplacement, fixed=true)
    "Aim behind the resonance";
  discrete Modelica.Units.SI.Length resonatedBefore(start=parameters.initialDisplacement, fixed=true)
    "The same at the tick before";
  discrete Modelica.Units.SI.Length crept(start=parameters.initialDisplacement, fixed=true)
    "Aim behind creep";
  discrete Modelica.Units.SI.Length target(start=coreRest, fixed=true)
    "Aim behind the fuzzy system, wherever it is";
  discrete Modelica.Units.SI.Length aim(start=coreRest, fixed=true) "The same, kept within reach";
  discrete Modelica.Units.SI.Voltage lagged(start=voltageRest, fixed=true) "Aim behind the lag";
  discrete Modelica.Units.SI.Voltage wanted(start=voltageRest, fixed=true)
    "Voltage that would take the plant to the aim";
  discrete Modelica.Units.SI.Voltage slewed(start=voltageRest, fixed=true)
    "Voltage that the slew limit starts from: at first it may lie beyond the saturation";
  discrete Modelica.Units.SI.Voltage reachedLag(start=voltageRest, fixed=true)
    "What the plant really has behind the lag";
  discrete Modelica.Units.SI.Voltage p[parameters.playCount + 1](
    start=playRest,
    each fixed=true) "Play operators of the plant";
  discrete Modelica.Units.SI.Length reached(start=coreRest, fixed=true)
    "What the plant really has behind the fuzzy system";
  discrete Modelica.Units.SI.Length s[parameters.creepCount + 1](
    each start=creepRest,
    each fixed=true) "Creep states of the plant";
  discrete Boolean short(start=false, fixed=true) "The reference was out of reach";
  discrete Boolean left(start=false, fixed=true) "The voltage left its range";
equation
  when sample(0, parameters.sampleTime) then
    resonated = reference - IT2Hysteresis.Functions.Effects.drift(
      parameters.driftTemperatureCoefficient,
      parameters.driftRate,
      temperatureInternal,
      time + parameters.delayTime);
    resonatedBefore = pre(resonated);
    crept = IT2Hysteresis.Functions.Effects.resonanceInverse(
      poles,
      pre(resonated),
      pre(resonatedBefore),
      resonated);
    target = IT2Hysteresis.Functions.Effects.loadInverse(
      parameters.loadCompliance,
      IT2Hysteresis.Functions.Effects.creepInverse(creepGain, creepRate, pre(s), crept),
      forceInternal);
    aim = min(max(target, parameters.displacementMin), parameters.displacementMax);
    lagged = IT2Hysteresis.Functions.Effects.playInverse(
      playThreshold,
      playWeight,
      pre(p),
      IT2Hysteresis.Functions.coreInverse(
        parameters.ruleSigmaLower,
        parameters.ruleSigmaUpper,
        parameters.ruleCentre,
        parameters.ruleQ1,
        parameters.ruleQ2,
        parameters.ruleQ3,
        pre(aim),
        aim,
        lowerEnd,
        upperEnd));
    wanted = IT2Hysteresis.Functions.Effects.lagInverse(lagRate, pre(lagged), lagged);
    voltage = IT2Hysteresis.Functions.Effects.slew(
      slewStep,
      pre(slewed),
      IT2Hysteresis.Functions.Effects.saturation(lowest, highest, wanted));
    slewed = voltage;
    saturated = target < parameters.displacementMin or target > parameters.displacementMax
      or abs(voltage - wanted) > negligible;
    reachedLag = IT2Hysteresis.Functions.Effects.lag(
      lagRate,
      pre(reachedLag),
      IT2Hysteresis.Functions.Effects.saturation(lowest, highest, voltage));
    p = IT2Hysteresis.Functions.Effects.playStates(
      playThreshold,
      pre(p),
      if slews or saturates then reachedLag else lagged);
    reached = if slews or saturates then IT2Hysteresis.Functions.core(
      parameters.ruleSigmaLower,
      parameters.ruleSigmaUpper,
      parameters.ruleCentre,
      parameters.ruleQ1,
      parameters.ruleQ2,
      parameters.ruleQ3,
      pre(reached),
      IT2Hysteresis.Functions.Effects.play(playWeight, p, reachedLag),
      lowerEnd,
      upperEnd) else aim;
    s = IT2Hysteresis.Functions.Effects.creepStates(
      creepRate,
      pre(s),
      IT2Hysteresis.Functions.Effects.load(parameters.loadCompliance, reached, forceInternal));
    short = pre(short) or saturated;
    left = pre(left) or abs(voltage - voltageMiddle) > voltageReach;
    assert(pre(short) or not short,
      "The reference left displacementMin .. displacementMax or what the amplifier lets through; "
      + "the nearest displacement is aimed at. This is said once.",
      AssertionLevel.warning);
    assert(pre(left) or not left,
      "The voltage left voltageMin .. voltageMax, the range that the parameters are valid for. "
      + "This is said once.",
      AssertionLevel.warning);
  end when;
  annotation (defaultComponentName="inverse", Documentation(info="<html>
<p>
At every tick t<sub>k</sub> = k <code>parameters.sampleTime</code> the reference walks the
<a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">chain</a> backwards: through the inverses of the effects behind the fuzzy
system, through (30) by <a href=\"modelica://IT2Hysteresis.Functions.coreInverse\">coreInverse</a>, and through the inverses of the effects in
front of it.
</p>
<p>
A reference outside <code>displacementMin</code> ... <code>displacementMax</code> is replaced by the nearest value inside, a
voltage beyond the amplifier's limits by the nearest that it can give, and <code>saturated</code> is true. What remembers
for long, play operators and creep, follows what the plant really reaches, so that nothing winds up. Leaving the range
is a warning, which is given once.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Inverse;
