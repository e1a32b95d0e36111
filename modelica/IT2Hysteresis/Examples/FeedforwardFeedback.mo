within IT2Hysteresis.Examples;
model FeedforwardFeedback "Feedforward by the inverse, and a PI controller for what it does not know"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 known(initialDisplacement=2.7e-6)
    "What the inverse knows: the fuzzy system";
  parameter IT2Hysteresis.Parameters.Table1 stage(
    initialDisplacement=2.7e-6,
    playThreshold={2,8},
    playWeight={0.04,0.06},
    creepGain={0.03},
    creepTimeConstant={0.05}) "What the stage is: memory and creep besides";
  Modelica.Blocks.Sources.Sine reference(
    amplitude=5.5e-6,
    f=20,
    phase=-Modelica.Constants.pi/2,
    offset=8.2e-6) "Desired displacement"
    annotation (Placement(transformation(extent={{-90,-10},{-70,10}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse inverse(parameters=known) "Feedforward"
    annotation (Placement(transformation(extent={{-50,20},{-30,40}})));
  IT2Hysteresis.Components.SampledPI controller(parameters=known) "Feedback"
    annotation (Placement(transformation(extent={{-50,-40},{-30,-20}})));
  Modelica.Blocks.Math.Add total "Voltage of the closed loop"
    annotation (Placement(transformation(extent={{-10,-20},{10,0}})));
  IT2Hysteresis.Blocks.PureModelica.Plant feedforward(parameters=stage) "Stage with feedforward alone"
    annotation (Placement(transformation(extent={{30,20},{50,40}})));
  IT2Hysteresis.Blocks.PureModelica.Plant closed(parameters=stage) "Stage with feedforward and feedback"
    annotation (Placement(transformation(extent={{30,-20},{50,0}})));
  Modelica.Blocks.Math.Feedback errorFeedforward "Error with feedforward alone"
    annotation (Placement(transformation(extent={{70,20},{90,40}})));
  Modelica.Blocks.Math.Feedback errorClosed "Error with feedforward and feedback"
    annotation (Placement(transformation(extent={{70,-20},{90,0}})));
equation
  connect(reference.y, inverse.reference)
    annotation (Line(points={{-69,0},{-60,0},{-60,30},{-52,30}}, color={0,0,127}));
  connect(reference.y, controller.reference)
    annotation (Line(points={{-69,0},{-60,0},{-60,-24},{-52,-24}}, color={0,0,127}));
  connect(inverse.voltage, feedforward.voltage)
    annotation (Line(points={{-29,30},{28,30}}, color={0,0,127}));
  connect(inverse.voltage, total.u1)
    annotation (Line(points={{-29,30},{-20,30},{-20,-4},{-12,-4}}, color={0,0,127}));
  connect(controller.y, total.u2)
    annotation (Line(points={{-29,-30},{-20,-30},{-20,-16},{-12,-16}}, color={0,0,127}));
  connect(total.y, closed.voltage)
    annotation (Line(points={{11,-10},{28,-10}}, color={0,0,127}));
  connect(closed.measured, controller.measured)
    annotation (Line(points={{51,-16},{60,-16},{60,-60},{-60,-60},{-60,-36},{-52,-36}}, color={0,0,127}));
  connect(reference.y, errorFeedforward.u1)
    annotation (Line(points={{-69,0},{-60,0},{-60,60},{64,60},{64,30},{72,30}}, color={0,0,127}));
  connect(feedforward.displacement, errorFeedforward.u2)
    annotation (Line(points={{51,30},{60,30},{60,14},{80,14},{80,22}}, color={0,0,127}));
  connect(reference.y, errorClosed.u1)
    annotation (Line(points={{-69,0},{-60,0},{-60,60},{64,60},{64,-10},{72,-10}}, color={0,0,127}));
  connect(closed.displacement, errorClosed.u2)
    annotation (Line(points={{51,-10},{60,-10},{60,-30},{80,-30},{80,-18}}, color={0,0,127}));
  annotation (
    experiment(StopTime=0.2, Interval=1e-4, Tolerance=1e-6),
    Documentation(info="<html>
<p>
The paper names feedback around the inverse as future work. Here the stage has rate-independent memory and creep besides the
fuzzy system that the inverse knows. Feedforward alone leaves their share as an error. A sampled PI controller sees the
displacement of the tick before and corrects the voltage.
</p>
<p>
Both stages are driven by the same inverse; <code>errorFeedforward.y</code> and <code>errorClosed.y</code> compare them. In the figure a line is as thick as the reference moves within a sample time,
while the displacement is held.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/FeedforwardFeedback.png\" width=\"640\" alt=\"Tracking errors with and without feedback over time, and the correction\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Tracking error",
          identifier="error",
          preferred=true,
          plots={
            Plot(curves={Curve(y=errorFeedforward.y, legend="Feedforward"), Curve(y=errorClosed.y, legend="Feedforward and PI")}),
            Plot(curves={Curve(y=controller.y, legend="Correction")})}),
        Figure(
          title="Displacement",
          identifier="displacement",
          plots={
            Plot(curves={Curve(y=reference.y, legend="Reference"), Curve(y=feedforward.displacement, legend="Feedforward"), Curve(y=closed.displacement, legend="Feedforward and PI")})})}));
end FeedforwardFeedback;
