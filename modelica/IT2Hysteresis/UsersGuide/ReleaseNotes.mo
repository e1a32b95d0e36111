within IT2Hysteresis.UsersGuide;
class ReleaseNotes "Release notes"
  extends Modelica.Icons.ReleaseNotes;
  annotation (DocumentationClass=true, Documentation(info="<html>
<h4>Version 0.1.0</h4>
<ul>
<li>The fuzzy model (10) and its inverse (30) as functions and as sampled blocks in pure Modelica.</li>
<li>The co-simulation FMUs IT2Plant and IT2Inverse as blocks, compiled from their C sources.</li>
<li>Effects around the fuzzy system: delay, slew limit, saturation, lag, play, load, creep, resonance, drift,
nonlinearity and hum.</li>
<li>Components for mechatronic models: <a href=\"modelica://IT2Hysteresis.Components.PiezoActuator\">PiezoActuator</a> with
electrical pins, translational flanges and a heat port, <a href=\"modelica://IT2Hysteresis.Components.VoltageAmplifier\">VoltageAmplifier</a>,
<a href=\"modelica://IT2Hysteresis.Components.ChargeAmplifier\">ChargeAmplifier</a>, <a href=\"modelica://IT2Hysteresis.Components.FlexureGuide\">FlexureGuide</a>,
<a href=\"modelica://IT2Hysteresis.Components.StrainGauge\">StrainGauge</a>, <a href=\"modelica://IT2Hysteresis.Components.PositionSensor\">PositionSensor</a> and
<a href=\"modelica://IT2Hysteresis.Components.SampledPI\">SampledPI</a>. Built from their defaults they begin at rest.</li>
<li><a href=\"modelica://IT2Hysteresis.Examples\">Examples</a> of feedforward, feedback, creep, temperature and stages of several parts, with stored
results. <a href=\"modelica://IT2Hysteresis.Examples.SlowCreep\">SlowCreep</a> rises within 5 s, so that no voltage is clamped.</li>
<li>Elements of a parameter set that are modified in place act. Unusable sets are refused by the pure blocks as by the FMUs,
with the same words; messages name the block, and the parameters as the records do. An effect of your own, which only the FMUs
compute, stops the pure blocks with the name of the block to take.</li>
<li>The pure plant takes a third of the time: it remembers as many voltages as its delay is long.</li>
<li>Parameter records count by their vectors: <code>parameters(playThreshold={2,8}, playWeight={0.05,0.04})</code> has two play
operators, and nothing else says so. Vectors that belong together must be of one length.</li>
<li>The examples' pictures show all curves that their texts name, every component's icon shows a value, and
<a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">PureModelica</a> says what a tick costs.</li>
<li>Controller and strain gauge take their sample time from the parameter set.</li>
<li>Parameter records, generated from the table of variables that the FMUs are generated from.</li>
</ul>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end ReleaseNotes;
