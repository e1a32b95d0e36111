within IT2Hysteresis.Examples;
model FeedforwardTracking "The inverse in front of the plant cancels the hysteresis"
  extends Modelica.Icons.Example;
  replaceable record Stage = IT2Hysteresis.Parameters.Table1
    constrainedby IT2Hysteresis.Parameters.Base "Parameter set"
    annotation (choicesAllMatching=true);
  parameter Stage stage(initialDisplacement=0.7e-6)
    "Actuator of the paper, at rest where the reference begins";
  Modelica.Blocks.Sources.Sine reference(
    amplitude=7e-6,
    f=20,
    phase=-Modelica.Constants.pi/2,
    offset=7.7e-6)
    "Desired displacement"
    annotation (Placement(transformation(extent={{-80,-10},{-60,10}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse inverse(parameters=stage) "Feedforward"
    annotation (Placement(transformation(extent={{-30,-10},{-10,10}})));
  IT2Hysteresis.Blocks.PureModelica.Plant plant(parameters=stage) "Actuator"
    annotation (Placement(transformation(extent={{20,-10},{40,10}})));
equation
  connect(reference.y, inverse.reference)
    annotation (Line(points={{-59,0},{-32,0}}, color={0,0,127}));
  connect(inverse.voltage, plant.voltage)
    annotation (Line(points={{-9,0},{18,0}}, color={0,0,127}));
  annotation (
    experiment(StopTime=0.1, Interval=1e-4, Tolerance=1e-6),
    Documentation(info="<html>
<p>
Feedforward control of the paper's reference
</p>
<p>
y<sub>d</sub> = 7.0 sin(2 &#960; 20 t - &#960;/2) + 7.7 &#181;m.
</p>
<p>
The inverse computes the voltage, which bends and lags so that the displacement does not: at every tick the displacement
equals the reference, and holds that value until the next tick.
</p>
<p>
To run it with an identified actuator, write the parameter set as a record with
<code>it2hys package PARAMETERS.ssv --modelica -o DIR</code>, load that record and redeclare:
</p>
<pre>
model Mine
  extends IT2Hysteresis.Examples.FeedforwardTracking(redeclare record Stage = MyStage);
end Mine;
</pre>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/FeedforwardTracking.png\" width=\"640\" alt=\"Reference and displacement over time, and displacement over voltage\"/>
</p>
</html>",
      revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Feedforward tracking",
          identifier="tracking",
          preferred=true,
          plots={
            Plot(
              curves={
                Curve(y=inverse.reference, legend="Reference"),
                Curve(y=plant.displacement, legend="Displacement")}),
            Plot(curves={Curve(y=inverse.voltage, legend="Voltage")})}),
        Figure(
          title="What the inverse compensates",
          identifier="loop",
          plots={
            Plot(curves={Curve(x=plant.voltage, y=plant.displacement, legend="Displacement over voltage")})})}));
end FeedforwardTracking;
