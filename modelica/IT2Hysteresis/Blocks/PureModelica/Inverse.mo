within IT2Hysteresis.Blocks.PureModelica;
block Inverse "Feedforward by the closed-form inverse: from desired displacement to voltage"
  extends IT2Hysteresis.Interfaces.PartialInverse;
protected
  discrete Modelica.Units.SI.Length aim(start=parameters.initialDisplacement, fixed=true)
    "Displacement that is aimed at: the reference, kept within reach";
equation
  when sample(0, parameters.sampleTime) then
    aim = min(max(reference, parameters.displacementMin), parameters.displacementMax);
    saturated = reference < parameters.displacementMin or reference > parameters.displacementMax;
    voltage = IT2Hysteresis.Functions.inverse(
      parameters.ruleSigmaLower,
      parameters.ruleSigmaUpper,
      parameters.ruleCentre,
      parameters.ruleQ1,
      parameters.ruleQ2,
      parameters.ruleQ3,
      pre(aim),
      aim);
    assert(not saturated,
      "The reference leaves displacementMin .. displacementMax; the nearest displacement within is aimed at.",
      AssertionLevel.warning);
    assert(voltage >= parameters.voltageMin and voltage <= parameters.voltageMax,
      "The voltage leaves voltageMin .. voltageMax, the range that the parameters are valid for.",
      AssertionLevel.warning);
  end when;
  annotation (defaultComponentName="inverse", Documentation(info="<html>
<p>
At every tick t<sub>k</sub> = k <code>parameters.sampleTime</code> the voltage x<sub>k</sub> that takes the plant from
y<sub>k-1</sub> to the reference y<sub>k</sub> follows from (30), see
<a href=\"modelica://IT2Hysteresis.Functions.inverse\">inverse</a>.
</p>
<p>
A reference outside <code>displacementMin</code> ... <code>displacementMax</code> is replaced by the nearest value inside, and
<code>saturated</code> is true. The state follows what is really aimed at, so that nothing winds up: back within reach,
the voltage is right from the first tick on. Leaving the range is a warning.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Inverse;
