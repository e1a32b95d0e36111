within IT2Hysteresis.Functions;
function check "Stops with the reason where a parameter set makes no usable model"
  extends Modelica.Icons.Function;
  input String name "Block that messages begin with";
  input Modelica.Units.SI.Time sampleTime "Sample time";
  input Modelica.Units.SI.Voltage voltageMin "Lower end of the voltage range";
  input Modelica.Units.SI.Voltage voltageMax "Upper end of the voltage range";
  input Modelica.Units.SI.Length displacementMin "Lower end of the range of the displacement";
  input Modelica.Units.SI.Length displacementMax "Upper end of the range of the displacement";
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Real leastSlope[2] "Of leastSlope";
  input Real contraction[2] "Of contraction";
  input Integer playCount "Number of play operators";
  input Modelica.Units.SI.Voltage playThreshold[:] "Their thresholds, and one more";
  input Real playWeight[size(playThreshold, 1)](each final unit="1") "Their weights";
  input Integer creepCount "Number of creep terms";
  input Real creepGain[:](each final unit="1") "Their gains, and one more";
  input Modelica.Units.SI.Time creepTimeConstant[size(creepGain, 1)] "Their time constants";
  input Modelica.Units.SI.Time delayTime "Delay";
  input Modelica.Units.SI.Voltage saturationMinimum "Lowest voltage of the amplifier";
  input Modelica.Units.SI.Voltage saturationMaximum "Highest voltage of the amplifier";
  input Modelica.Units.SI.Time lagTimeConstant "Time constant of the lag";
  input Modelica.Units.SI.Frequency resonanceFrequency "Undamped natural frequency";
  input Real resonanceDamping(final unit="1") "Damping, of critical";
  input Real resonanceSamplingZero(final unit="1") "Zero of the sampled resonance";
  input Modelica.Units.SI.Time resonanceSamplingDelay "Delay that goes with the resonance";
  input Modelica.Units.SI.Length curve[5] "Coefficients of the static curve";
  input Modelica.Units.SI.Length nonlinearityMinimum "Lower end of the curve, from displacementZero";
  input Modelica.Units.SI.Length nonlinearityMaximum "Upper end of the curve, from displacementZero";
  input Modelica.Units.SI.Length humAmplitude "Amplitude of the hum";
  input Modelica.Units.SI.Frequency humFrequency "Frequency of the hum";
  input Modelica.Units.SI.Length initialDisplacement "Displacement before the first tick";
  input Modelica.Units.SI.Length coreRest "What it is behind the fuzzy system";
protected
  constant Integer grid=256 "Intervals of a grid over the static curve";
  constant Real farthest=4.0 "How far beyond the range a run may begin, in lengths of the range";
  constant Integer longestDelay=64 "In ticks";
  constant Integer longestRinging=2 "Ticks of delay that go with a resonance";
  constant Real rounding=1e-9 "Ticks: a time that is a whole number of them but for rounding is taken as whole";
  constant Real slowestLag=1e9 "Sample times: a slower pole would leave too few digits for the inverse";
  constant Real lowestZero=-0.95 "Nearer to -1 the inverse would ring for long";
  constant Real slowestResonance=1e-5 "Per sample time: slower poles would leave too few digits in 1 - a1 - a2";
  Integer rules=size(s1, 1) "Number of rules";
  Integer operators=playCount "Number of play operators";
  Integer terms=creepCount "Number of creep terms";
  Modelica.Units.SI.Length reach=farthest*(displacementMax - displacementMin) "How far beyond the range";
  Real total "1 plus weights, or negative gains";
  Modelica.Units.SI.Voltage least "The threshold before";
  Real z "-1 to 1 over the static curve";
  Modelica.Units.SI.Length y "Displacement there, above displacementZero";
  Real rise "Derivative of the static curve";
algorithm
  assert(voltageMin < voltageMax, name + ": voltageMin, " + String(voltageMin, significantDigits=6)
    + " V, must be below voltageMax, " + String(voltageMax, significantDigits=6) + " V.");
  assert(displacementMin < displacementMax, name + ": displacementMin, "
    + String(displacementMin, significantDigits=6) + ", must be below displacementMax, "
    + String(displacementMax, significantDigits=6) + ".");
  for l in 1:rules loop
    assert(s2[l] >= s1[l], name + ": ruleSigmaUpper[" + String(l) + "] is " + String(s2[l], significantDigits=6)
      + ", below ruleSigmaLower[" + String(l) + "], " + String(s1[l], significantDigits=6)
      + "; the upper membership must be the wider one (are the two swapped?).");
  end for;
  assert(leastSlope[1] > 0, name + ": the sum of ruleQ2 times the memberships is not positive at a displacement of "
    + String(leastSlope[2], significantDigits=6) + ": the model cannot be inverted there; raise q2 of the rules near it or "
    + "narrow displacementMin..displacementMax.");
  assert(contraction[1] < 1, name + ": the contraction |dy_k/dy_{k-1}| is "
    + String(contraction[1], significantDigits=4) + " at a displacement of "
    + String(contraction[2], significantDigits=6)
    + ", where it must be below 1: a free run diverges; lower ruleQ1 or narrow displacementMin..displacementMax.");
  assert(delayTime <= (longestDelay + rounding)*sampleTime, name + ": delayTime is "
    + String(delayTime, significantDigits=6) + " s; at a sampleTime of " + String(sampleTime, significantDigits=6)
    + " s it must be at most " + String(longestDelay*sampleTime, significantDigits=6) + " s, "
    + String(longestDelay) + " ticks.");
  assert(abs(saturationMinimum) <= 0 and abs(saturationMaximum) <= 0 or saturationMinimum < saturationMaximum,
    name + ": saturationMinimum, " + String(saturationMinimum, significantDigits=6)
    + " V, must be below saturationMaximum, " + String(saturationMaximum, significantDigits=6)
    + " V (both 0: no saturation).");
  assert(lagTimeConstant <= slowestLag*sampleTime, name + ": lagTimeConstant is "
    + String(lagTimeConstant, significantDigits=6) + " s; at a sampleTime of "
    + String(sampleTime, significantDigits=6) + " s it must be at most "
    + String(slowestLag*sampleTime, significantDigits=6) + " s.");
  least := 0.0;
  total := 1.0;
  for j in 1:operators loop
    assert(playThreshold[j] >= least, name + ": playThreshold[" + String(j) + "] is "
      + String(playThreshold[j], significantDigits=6) + " V; thresholds must rise, so it must be at least "
      + String(least, significantDigits=6) + " V.");
    least := playThreshold[j];
    total := total + playWeight[j];
    assert(total > 0, name + ": 1 plus the weights up to playWeight[" + String(j) + "] is "
      + String(total, significantDigits=6)
      + "; it must be positive: the play operators would not be monotone and could not be inverted.");
  end for;
  total := 1.0;
  for i in 1:terms loop
    assert(creepTimeConstant[i] > 0, name + ": creepTimeConstant[" + String(i) + "] is "
      + String(creepTimeConstant[i], significantDigits=6) + " s; it must be positive.");
    total := total + min(creepGain[i], 0);
    assert(total > 0, name + ": 1 plus the negative gains up to creepGain[" + String(i) + "] is "
      + String(total, significantDigits=6) + "; it must be positive: creep could not be inverted.");
  end for;
  assert(resonanceFrequency <= 0 or resonanceFrequency >= slowestResonance/sampleTime
    and resonanceFrequency < 0.5/sampleTime, name + ": resonanceFrequency is "
    + String(resonanceFrequency, significantDigits=6) + " Hz; at a sampleTime of "
    + String(sampleTime, significantDigits=6) + " s it must be "
    + String(slowestResonance/sampleTime, significantDigits=6) + " Hz to below "
    + String(0.5/sampleTime, significantDigits=6) + " Hz (Nyquist), or 0 for none.");
  assert(resonanceFrequency <= 0 or resonanceDamping > 0 and resonanceDamping < 1, name
    + ": resonanceDamping is " + String(resonanceDamping, significantDigits=6)
    + "; it must be above 0 and below 1.");
  assert(resonanceFrequency <= 0 or resonanceSamplingZero >= lowestZero and resonanceSamplingZero <= 0, name
    + ": resonanceSamplingZero is " + String(resonanceSamplingZero, significantDigits=6) + "; it must be "
    + String(lowestZero, significantDigits=6) + " to 0.");
  assert(resonanceFrequency <= 0 or resonanceSamplingDelay >= 0 and resonanceSamplingDelay <= longestRinging*
    sampleTime*(1 + rounding), name + ": resonanceSamplingDelay is " + String(resonanceSamplingDelay,
    significantDigits=6) + " s; at a sampleTime of " + String(sampleTime, significantDigits=6) + " s it must be 0 to "
    + String(longestRinging*sampleTime, significantDigits=6) + " s, " + String(longestRinging) + " ticks.");
  assert(max(abs(curve)) <= 0 or nonlinearityMinimum < nonlinearityMaximum, name + ": nonlinearityMinimum, "
    + String(nonlinearityMinimum, significantDigits=6) + " m, must be below nonlinearityMaximum, "
    + String(nonlinearityMaximum, significantDigits=6) + " m.");
  for i in 0:grid loop
    z := 2*i/grid - 1;
    y := (nonlinearityMinimum + nonlinearityMaximum)/2 + z*(nonlinearityMaximum - nonlinearityMinimum)/2;
    rise := (nonlinearityMaximum - nonlinearityMinimum)/2
      - 2*z*(curve[1] + z*(curve[2] + z*(curve[3] + z*(curve[4] + z*curve[5]))))
      + (1 - z^2)*(curve[2] + z*(2*curve[3] + z*(3*curve[4] + 4*z*curve[5])));
    assert(max(abs(curve)) <= 0 or rise > 0, name
      + ": nonlinearityQuadratic to nonlinearitySextic make a curve that falls "
      + String(y, significantDigits=6) + " m above displacementZero; it must rise from nonlinearityMinimum to nonlinearityMaximum.");
  end for;
  assert(humAmplitude >= 0, name + ": humAmplitude is " + String(humAmplitude, significantDigits=6)
    + " m; it must be positive, or 0 for none.");
  assert(humAmplitude <= 0 or humFrequency > 0, name + ": humFrequency is "
    + String(humFrequency, significantDigits=6) + " Hz; with a humAmplitude it must be positive.");
  assert(coreRest >= displacementMin - reach and coreRest <= displacementMax + reach, name
    + ": initialDisplacement is " + String(initialDisplacement, significantDigits=6)
    + " m: the run would begin more than " + String(farthest, significantDigits=6)
    + " times the length of displacementMin..displacementMax, " + String(displacementMin, significantDigits=6)
    + " to " + String(displacementMax, significantDigits=6)
    + " m, outside it; set it to where the stage is (is it in another unit?).");
  annotation (Documentation(info="<html>
<p>
The blocks of <a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">PureModelica</a> call it at their initialization, behind
<a href=\"modelica://IT2Hysteresis.Internal.checkBounds\">checkBounds</a>. It refuses what the FMUs refuse, with their words.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end check;
