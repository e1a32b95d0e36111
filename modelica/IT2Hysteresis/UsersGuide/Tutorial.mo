within IT2Hysteresis.UsersGuide;
class Tutorial "From drag and drop to a closed loop, in five steps"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>Make a new model, and drag into it. Every step is a model that simulates.</p>
<h4>1. A plant</h4>
<p>
Drag <a href=\"modelica://IT2Hysteresis.Blocks.PureModelica.Plant\">Blocks.PureModelica.Plant</a> and a
<code>Modelica.Blocks.Sources.Sine</code> with <code>amplitude=45</code>, <code>offset=50</code>, <code>f=20</code>, and connect the sine to
<code>voltage</code>. Simulate 0.2 s and plot <code>plant.displacement</code> over <code>plant.voltage</code>: a loop. It is
that of the paper's actuator, <a href=\"modelica://IT2Hysteresis.Parameters.Table1\">Table1</a>. The block
<a href=\"modelica://IT2Hysteresis.Blocks.Plant\">Blocks.Plant</a> computes the same by the FMU; a C compiler is needed for it, and a tick costs a
small part of the time.
</p>
<h4>2. A set of your own</h4>
<p>
<code>it2hys package PARAMETERS.ssv --modelica -o DIR</code> writes an identified set as a record; load its file. Declare it
once in the model and hand it over, here with an element modified:
</p>
<pre>
parameter MyStage stage(initialDisplacement=1e-6);
IT2Hysteresis.Blocks.PureModelica.Plant plant(parameters=stage);
</pre>
<p>
Or choose the record in the dialog, as <code>Stage</code>, and modify it in place:
<code>plant(redeclare record Stage = MyStage, parameters(lagTimeConstant=1e-3))</code>. How many rules, play operators and creep terms there
are follows from their vectors: <code>parameters(playThreshold={2,8}, playWeight={0.05,0.04})</code> has two play operators. Vectors
that belong together must be of one length; the block says which is not. <code>playCount</code> and its like are there to be read.
</p>
<h4>3. Feedforward</h4>
<p>
Drag <a href=\"modelica://IT2Hysteresis.Blocks.PureModelica.Inverse\">Blocks.PureModelica.Inverse</a>, hand it the same record, connect its
<code>voltage</code> to the plant's and a reference in metres to its <code>reference</code>: at every tick the displacement is the
reference. <code>saturated</code> is true where voltage or range do not allow it. See
<a href=\"modelica://IT2Hysteresis.Examples.FeedforwardTracking\">FeedforwardTracking</a>.
</p>
<h4>4. A machine</h4>
<p>
Put a <a href=\"modelica://IT2Hysteresis.Components.PiezoActuator\">PiezoActuator</a> in the place of the plant: <code>p</code> and
<code>n</code> to a <a href=\"modelica://IT2Hysteresis.Components.VoltageAmplifier\">VoltageAmplifier</a> with <code>k=1</code> and a ground at <code>n</code>,
<code>flange_a</code> to a <code>Modelica.Mechanics.Translational.Components.Fixed</code>, <code>flange_b</code> to a
<a href=\"modelica://IT2Hysteresis.Components.FlexureGuide\">FlexureGuide</a>. Hand the actuator the record as <code>stage</code>: it begins at rest where
<code>initialDisplacement</code> is, which is 0 V by default. Let the amplifier begin there, too: <code>vStart=actuator.vStart</code>. See
<a href=\"modelica://IT2Hysteresis.Examples.FMUStage\">FMUStage</a>.
</p>
<h4>5. A closed loop</h4>
<p>
Drag a <a href=\"modelica://IT2Hysteresis.Components.StrainGauge\">StrainGauge</a> between the actuator's flanges, with
<code>offset=actuator.length</code>, and a <a href=\"modelica://IT2Hysteresis.Components.SampledPI\">SampledPI</a>; hand both the record, which gives them
the sample time. Connect the gauge to <code>measured</code>, the reference to <code>reference</code>, and add the controller's voltage to the
inverse's with a <code>Modelica.Blocks.Math.Add</code> in front of the amplifier. See
<a href=\"modelica://IT2Hysteresis.Examples.DisturbanceForce\">DisturbanceForce</a>, and
<a href=\"modelica://IT2Hysteresis.Examples.IntegralFeedback\">IntegralFeedback</a> where a resonance limits the gain.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Tutorial;
