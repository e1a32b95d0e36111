within IT2Hysteresis.Blocks.PureModelica;
block Inverse "Feedforward by the closed-form inverse: from desired displacement to voltage"
  extends IT2Hysteresis.Interfaces.PartialInverse;
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
  constant Real same=1e-10 "Values of a range are the same if no more than this share of it is between them";
  final parameter Modelica.Units.SI.Length sameLength=
    same*(parameters.displacementMax - parameters.displacementMin) "The same for displacements";
  final parameter Modelica.Units.SI.Voltage sameVoltage=same*(parameters.voltageMax - parameters.voltageMin)
    "The same for voltages";
  final parameter Boolean lags=parameters.lagTimeConstant > 0 "= true, if the amplifier has a lag";
  final parameter Boolean resonates=parameters.resonanceFrequency > 0 "= true, if there is a resonance";
  final parameter Modelica.Units.SI.Length overshoot=
    if resonates then parameters.displacementMax - parameters.displacementMin else 0
    "What rings reads beyond where it comes to rest, by up to the height of a step";
  final parameter Boolean bare=not (chain.slews or chain.saturates or lags or resonates or chain.bends
    or parameters.delayTime > 0 or chain.playCount > 0 or parameters.loadCompliance > 0 or chain.creepCount > 0
    or abs(parameters.driftTemperatureCoefficient) > 0 or abs(parameters.driftRate) > 0)
    "= true, if there is the fuzzy system alone";
  discrete Modelica.Units.SI.Length desired(start=initialDisplacement, fixed=true)
    "Reference, kept within its range";
  discrete Modelica.Units.SI.Length resonated(start=chain.straightRest, fixed=true) "Aim behind the resonance";
  discrete Modelica.Units.SI.Length resonatedBefore(start=chain.straightRest, fixed=true)
    "The same at the tick before";
  discrete Modelica.Units.SI.Length crept(start=chain.straightRest, fixed=true) "Aim behind creep";
  discrete Modelica.Units.SI.Length aim(start=chain.coreRest, fixed=true) "Aim behind the fuzzy system";
  discrete Modelica.Units.SI.Voltage lagged(start=chain.voltageRest, fixed=true) "Aim behind the lag";
  discrete Modelica.Units.SI.Voltage wanted(start=chain.voltageRest, fixed=true)
    "Voltage that would take the plant to the aim";
  discrete Modelica.Units.SI.Voltage possible(start=chain.voltageRest, fixed=true)
    "Nearest voltage within the amplifier's limits";
  discrete Modelica.Units.SI.Voltage allowed(start=chain.voltageRest, fixed=true)
    "Nearest voltage that is in its range besides";
  discrete Modelica.Units.SI.Voltage slewed(start=chain.voltageRest, fixed=true)
    "Voltage behind the slew limit: at first it may lie beyond the others";
  discrete Boolean cut(start=false, fixed=true) "The voltage that is wanted is not given";
  discrete Boolean followed(start=false, fixed=true)
    "The plant is not where it was aimed at, or will not get there";
  discrete Modelica.Units.SI.Voltage nowLag(start=chain.voltageRest, fixed=true)
    "What the plant has behind the lag";
  discrete Modelica.Units.SI.Voltage p[chain.playCount + 1](
    start=chain.playRest,
    each fixed=true) "Play operators of the plant";
  discrete Modelica.Units.SI.Length now(start=chain.coreRest, fixed=true)
    "What the plant has behind the fuzzy system";
  discrete Modelica.Units.SI.Length stroke(start=chain.strokeRest, fixed=true)
    "The same behind the load, above the sensor's zero";
  discrete Modelica.Units.SI.Length s[chain.creepCount + 1](
    start=chain.creepRest,
    each fixed=true) "Creep states of the plant";
  discrete Modelica.Units.SI.Length nowCrept(start=chain.straightRest, fixed=true) "The same behind creep";
  discrete Modelica.Units.SI.Length nowResonated(start=chain.straightRest, fixed=true)
    "What the plant has behind the resonance";
  discrete Boolean astray(start=false, fixed=true) "The plant is not where it was aimed at";
  discrete Modelica.Units.SI.Length reached(start=chain.coreRest, fixed=true)
    "Where the plant is taken to be, behind the fuzzy system";
  discrete Modelica.Units.SI.Voltage reachedLag(start=chain.voltageRest, fixed=true) "The same behind the lag";
  discrete Modelica.Units.SI.Length reachedCrept(start=chain.straightRest, fixed=true) "The same behind creep";
  discrete Modelica.Units.SI.Length reachedResonated(start=chain.straightRest, fixed=true)
    "The same behind the resonance";
  discrete Modelica.Units.SI.Length reachedBefore(start=chain.straightRest, fixed=true)
    "The same at the tick before";
  discrete Boolean short(start=false, fixed=true) "Something was cut off";
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
    assert(abs(reference) < Modelica.Constants.inf,
      getInstanceName() + ": reference must be a finite number, not " + String(reference) + ".");
    desired = min(max(reference, parameters.displacementMin - overshoot), parameters.displacementMax + overshoot);
    resonated = (if chain.bends then IT2Hysteresis.Functions.Effects.nonlinearityInverse(
      chain.curve,
      chain.curveMin,
      chain.curveMax,
      desired) else desired) - IT2Hysteresis.Functions.Effects.drift(
      parameters.driftTemperatureCoefficient,
      parameters.driftRate,
      temperatureInternal,
      time + parameters.delayTime + chain.resonanceDelay);
    resonatedBefore = pre(resonated);
    crept = if resonates then IT2Hysteresis.Functions.Effects.resonanceInverse(
      chain.ringing,
      pre(resonated),
      pre(resonatedBefore),
      pre(crept),
      resonated) else resonated;
    aim = IT2Hysteresis.Functions.Effects.loadInverse(
      parameters.loadCompliance,
      if chain.creepCount > 0 then parameters.displacementZero + IT2Hysteresis.Functions.Effects.creepInverse(
        chain.creepGain,
        chain.creepRate,
        pre(s),
        crept - parameters.displacementZero) else crept,
      forceInternal);
    lagged = IT2Hysteresis.Functions.Effects.playInverse(
      chain.playThreshold,
      chain.playWeight,
      pre(p),
      IT2Hysteresis.Functions.coreInverse(
        chain.ruleSigmaLower,
        chain.ruleSigmaUpper,
        chain.ruleCentre,
        chain.ruleQ1,
        chain.ruleQ2,
        chain.ruleQ3,
        if bare then pre(reached) else pre(aim),
        aim,
        chain.lowerEnd,
        chain.upperEnd));
    wanted = IT2Hysteresis.Functions.Effects.lagInverse(chain.lagRate, pre(lagged), lagged);
    possible = IT2Hysteresis.Functions.Effects.saturation(chain.lowest, chain.highest, wanted);
    allowed = IT2Hysteresis.Functions.Effects.saturation(
      parameters.voltageMin,
      parameters.voltageMax,
      possible);
    slewed = IT2Hysteresis.Functions.Effects.slew(chain.slewStep, pre(slewed), allowed);
    voltage = IT2Hysteresis.Functions.Effects.saturation(
      parameters.voltageMin,
      parameters.voltageMax,
      slewed);
    cut = abs(possible - wanted) > sameVoltage or abs(allowed - possible) > sameVoltage
      or abs(slewed - allowed) > sameVoltage or abs(voltage - slewed) > sameVoltage;
    followed = cut or pre(astray);
    nowLag = if followed then IT2Hysteresis.Functions.Effects.lag(
      chain.lagRate,
      pre(reachedLag),
      IT2Hysteresis.Functions.Effects.saturation(chain.lowest, chain.highest, slewed)) else lagged;
    p = if chain.playCount > 0 then IT2Hysteresis.Functions.Effects.playStates(
      chain.playThreshold,
      pre(p),
      nowLag) else pre(p);
    now = if followed then IT2Hysteresis.Functions.core(
      chain.ruleSigmaLower,
      chain.ruleSigmaUpper,
      chain.ruleCentre,
      chain.ruleQ1,
      chain.ruleQ2,
      chain.ruleQ3,
      pre(reached),
      IT2Hysteresis.Functions.Effects.play(chain.playWeight, p, nowLag),
      chain.lowerEnd,
      chain.upperEnd) else aim;
    stroke = IT2Hysteresis.Functions.Effects.load(parameters.loadCompliance, now, forceInternal)
      - parameters.displacementZero;
    s = if chain.creepCount > 0 then IT2Hysteresis.Functions.Effects.creepStates(
      chain.creepRate,
      pre(s),
      stroke) else pre(s);
    nowCrept = if followed then parameters.displacementZero + IT2Hysteresis.Functions.Effects.creep(
      chain.creepGain,
      s,
      stroke) else crept;
    nowResonated = if followed then IT2Hysteresis.Functions.Effects.resonance(
      chain.ringing,
      pre(reachedResonated),
      pre(reachedBefore),
      pre(reachedCrept),
      nowCrept) else resonated;
    astray = followed and not bare and (abs(now - aim) > sameLength
      or lags and abs(nowLag - lagged) > sameVoltage
      or resonates and (abs(nowResonated - resonated) > sameLength
      or abs(nowCrept - crept) > sameLength
      or abs(pre(reachedResonated) - pre(resonated)) > sameLength));
    reached = if astray or bare then now else aim;
    reachedLag = if astray then nowLag else lagged;
    reachedCrept = if astray then nowCrept else crept;
    reachedResonated = if astray then nowResonated else resonated;
    reachedBefore = if astray then pre(reachedResonated) else pre(resonated);
    saturated = reference < parameters.displacementMin - overshoot or reference > parameters.displacementMax + overshoot
      or cut or astray;
    short = pre(short) or saturated;
    assert(pre(short) or not short,
      getInstanceName() + ": the reference left displacementMin..displacementMax, or asks for more than "
      + "voltageMin..voltageMax or the amplifier's limits allow; the nearest displacement or voltage is given. This is said once.",
      AssertionLevel.warning);
  end when;
  annotation (
    defaultComponentName="inverse",
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Text(
          extent={{4,-60},{96,-96}},
          textString="pure",
          textColor={128,128,128})}),
    Documentation(info="<html>
<p>
At every tick t<sub>k</sub> = k <code>parameters.sampleTime</code> the reference walks the
<a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">chain</a> backwards: through the inverses of the effects behind the fuzzy
system, through (30) by <a href=\"modelica://IT2Hysteresis.Functions.coreInverse\">coreInverse</a>, and through the inverses of the effects in
front of it.
</p>
<p>
A reference outside <code>displacementMin</code> ... <code>displacementMax</code> (with a resonance, farther outside than the whole range
is long: a stage that rings gets there) is replaced by the nearest value inside, a
voltage outside <code>voltageMin</code> ... <code>voltageMax</code> or the amplifier's limits by the nearest that can be given. Until the
plant is where the reference is again, <code>saturated</code> is true. The fuzzy system alone goes on from what it reached. With
effects, what remembers for long, play operators and creep, follows what the plant really reaches, and the rest comes
back by its own contraction: nothing winds up. That something was cut off is a warning, which is given once.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Inverse;
