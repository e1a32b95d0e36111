within IT2Hysteresis.Examples;
model HysteresisLoop "The paper's identification signal and the loop that it draws"
  extends Modelica.Icons.Example;
  Modelica.Blocks.Sources.Sine tone50(
    amplitude=40,
    f=50,
    phase=-Modelica.Constants.pi/2,
    offset=62.5)
    "50 Hz and the mean"
    annotation (Placement(transformation(extent={{-80,20},{-60,40}})));
  Modelica.Blocks.Sources.Sine tone25(
    amplitude=22.5,
    f=25,
    phase=-Modelica.Constants.pi/2)
    "25 Hz"
    annotation (Placement(transformation(extent={{-80,-40},{-60,-20}})));
  Modelica.Blocks.Math.Add signal22 "The sum (22)"
    annotation (Placement(transformation(extent={{-40,-10},{-20,10}})));
  IT2Hysteresis.Blocks.PureModelica.Plant plant "Actuator of the paper, Table 1"
    annotation (Placement(transformation(extent={{20,-10},{40,10}})));
  Modelica.Blocks.Discrete.Sampler held(samplePeriod=plant.parameters.sampleTime)
    "The voltage as the plant sees it: at the ticks"
    annotation (Placement(transformation(extent={{20,-50},{40,-30}})));
equation
  connect(tone50.y, signal22.u1)
    annotation (Line(points={{-59,30},{-50,30},{-50,6},{-42,6}}, color={0,0,127}));
  connect(tone25.y, signal22.u2)
    annotation (Line(points={{-59,-30},{-50,-30},{-50,-6},{-42,-6}}, color={0,0,127}));
  connect(signal22.y, plant.voltage)
    annotation (Line(points={{-19,0},{18,0}}, color={0,0,127}));
  connect(signal22.y, held.u)
    annotation (Line(points={{-19,0},{0,0},{0,-40},{18,-40}}, color={0,0,127}));
  annotation (
    experiment(StopTime=0.12, Interval=1e-4, Tolerance=1e-6),
    Documentation(info="<html>
<p>
The actuator of the paper's Table 1 under the paper's identification signal
</p>
<p>
x = 40 sin(2 &#960; 50 t - &#960;/2) + 22.5 sin(2 &#960; 25 t - &#960;/2) + 62.5 V &#160; (22).
</p>
<p>
Plotted over the voltage at the ticks, the displacement draws a large loop and a small one inside; over the continuous voltage it
would draw stairs, since it is held from tick to tick. The first period starts at
<code>initialDisplacement</code> = 0 and closes on the loop that all later ones follow.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/HysteresisLoop.png\" width=\"640\" alt=\"Displacement over voltage: a large loop with a small one inside\"/>
</p>
</html>",
      revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Hysteresis loop",
          identifier="loop",
          preferred=true,
          plots={
            Plot(curves={Curve(x=held.y, y=plant.displacement, legend="Displacement over voltage")})}),
        Figure(
          title="Signals over time",
          identifier="signals",
          plots={
            Plot(curves={Curve(y=plant.voltage, legend="Voltage")}),
            Plot(curves={Curve(y=plant.displacement, legend="Displacement")})})}));
end HysteresisLoop;
