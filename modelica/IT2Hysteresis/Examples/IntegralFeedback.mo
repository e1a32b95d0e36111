within IT2Hysteresis.Examples;
model IntegralFeedback "Feedback around a resonance: integral instead of proportional"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 stage(
    initialDisplacement=4e-6,
    resonanceFrequency=400,
    resonanceDamping=0.02) "Table 1 on a stage that rings at 400 Hz";
  Modelica.Blocks.Sources.Pulse reference(
    amplitude=3e-6,
    width=50,
    period=0.2,
    nperiod=1,
    offset=4e-6,
    startTime=0.01) "Desired displacement: a step of 3 um, and back"
    annotation (Placement(transformation(extent={{-90,-10},{-70,10}})));
  Modelica.Blocks.Sources.Constant hold(k=23.5) "Voltage at which the stage rests at 4 um"
    annotation (Placement(transformation(extent={{-90,50},{-70,70}})));
  IT2Hysteresis.Components.SampledPI proportional(
    parameters=stage,
    k=5e5,
    Ti=2e-3) "Proportional and integral part"
    annotation (Placement(transformation(extent={{-40,20},{-20,40}})));
  Modelica.Blocks.Math.Add first "Voltage"
    annotation (Placement(transformation(extent={{0,26},{20,46}})));
  IT2Hysteresis.Blocks.PureModelica.Plant ringing(parameters=stage) "Stage in the first loop"
    annotation (Placement(transformation(extent={{40,26},{60,46}})));
  IT2Hysteresis.Components.SampledPI integral(
    parameters=stage,
    k=1e4,
    Ti=1.2e-5) "Integral part alone, but for a little"
    annotation (Placement(transformation(extent={{-40,-50},{-20,-30}})));
  Modelica.Blocks.Math.Add second "Voltage"
    annotation (Placement(transformation(extent={{0,-44},{20,-24}})));
  IT2Hysteresis.Blocks.PureModelica.Plant plant(parameters=stage) "Stage in the second loop"
    annotation (Placement(transformation(extent={{40,-44},{60,-24}})));
equation
  connect(reference.y, proportional.reference)
    annotation (Line(points={{-69,0},{-56,0},{-56,36},{-42,36}}, color={0,0,127}));
  connect(reference.y, integral.reference)
    annotation (Line(points={{-69,0},{-56,0},{-56,-34},{-42,-34}}, color={0,0,127}));
  connect(hold.y, first.u1)
    annotation (Line(points={{-69,60},{-10,60},{-10,42},{-2,42}}, color={0,0,127}));
  connect(proportional.y, first.u2)
    annotation (Line(points={{-19,30},{-2,30}}, color={0,0,127}));
  connect(first.y, ringing.voltage)
    annotation (Line(points={{21,36},{38,36}}, color={0,0,127}));
  connect(ringing.measured, proportional.measured)
    annotation (Line(points={{61,30},{70,30},{70,10},{-50,10},{-50,24},{-42,24}}, color={0,0,127}));
  connect(hold.y, second.u1)
    annotation (Line(points={{-69,60},{-62,60},{-62,-14},{-10,-14},{-10,-28},{-2,-28}}, color={0,0,127}));
  connect(integral.y, second.u2)
    annotation (Line(points={{-19,-40},{-2,-40}}, color={0,0,127}));
  connect(second.y, plant.voltage)
    annotation (Line(points={{21,-34},{38,-34}}, color={0,0,127}));
  connect(plant.measured, integral.measured)
    annotation (Line(points={{61,-40},{70,-40},{70,-60},{-50,-60},{-50,-46},{-42,-46}}, color={0,0,127}));
  annotation (
    experiment(StopTime=0.2, Interval=1e-4, Tolerance=1e-6),
    Documentation(info="<html>
<p>
A stage with little damping rings at 400 Hz, where its gain is 25 times that at rest. A proportional part feeds that back: a quarter of the
controller's default gain makes it ring for long after every step, and the default gain would make the loop oscillate. An integral part
alone falls with the frequency: at 400 Hz its loop has a gain below 1, and the displacement settles.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/IntegralFeedback.png\" width=\"640\" alt=\"Displacement in both loops, and both voltages, over time\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="A step in both loops",
          identifier="step",
          preferred=true,
          plots={
            Plot(curves={Curve(y=reference.y, legend="Reference"), Curve(y=ringing.displacement, legend="Proportional and integral"), Curve(y=plant.displacement, legend="Integral")}),
            Plot(curves={Curve(y=first.y, legend="Voltage, proportional and integral"), Curve(y=second.y, legend="Voltage, integral")})})}));
end IntegralFeedback;
