within IT2Hysteresis.Blocks.PureModelica;
block Plant "Actuator with hysteresis: from voltage to displacement"
  extends IT2Hysteresis.Interfaces.PartialPlant;
equation
  when sample(0, parameters.sampleTime) then
    displacement = IT2Hysteresis.Functions.step(
      parameters.ruleSigmaLower,
      parameters.ruleSigmaUpper,
      parameters.ruleCentre,
      parameters.ruleQ1,
      parameters.ruleQ2,
      parameters.ruleQ3,
      pre(displacement),
      voltage);
    assert(voltage >= parameters.voltageMin and voltage <= parameters.voltageMax,
      "The voltage leaves voltageMin .. voltageMax, the range that the parameters are valid for.",
      AssertionLevel.warning);
    assert(displacement >= parameters.displacementMin and displacement <= parameters.displacementMax,
      "The displacement leaves displacementMin .. displacementMax; beyond it the model may diverge.",
      AssertionLevel.warning);
  end when;
  measured = displacement;
  annotation (defaultComponentName="plant", Documentation(info="<html>
<p>
At every tick t<sub>k</sub> = k <code>parameters.sampleTime</code> the displacement y<sub>k</sub> follows from the voltage
x<sub>k</sub> and the displacement y<sub>k-1</sub> of the tick before by (10), see
<a href=\"modelica://IT2Hysteresis.Functions.step\">step</a>. Without effects of the sensor, <code>measured</code> equals
<code>displacement</code>.
</p>
<p>
Leaving the range that the parameters are valid for is a warning.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Plant;
