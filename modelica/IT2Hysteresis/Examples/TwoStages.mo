within IT2Hysteresis.Examples;
model TwoStages "A coarse and a fine stack in series"
  extends Modelica.Icons.Example;
  Modelica.Blocks.Sources.Sine coarseCommand(
    amplitude=30,
    f=10,
    phase=-Modelica.Constants.pi/2,
    offset=32) "Voltage of the coarse stack"
    annotation (Placement(transformation(extent={{-90,50},{-70,70}})));
  Modelica.Blocks.Sources.Sine fineCommand(
    amplitude=10,
    f=150,
    phase=-Modelica.Constants.pi/2,
    offset=11) "Voltage of the fine stack"
    annotation (Placement(transformation(extent={{-90,10},{-70,30}})));
  IT2Hysteresis.Components.VoltageAmplifier coarseAmplifier(k=1, vStart=coarse.vStart) "Amplifier of the coarse stack"
    annotation (Placement(transformation(extent={{-50,50},{-30,70}})));
  IT2Hysteresis.Components.VoltageAmplifier fineAmplifier(k=1, vStart=fine.vStart) "Amplifier of the fine stack"
    annotation (Placement(transformation(extent={{-50,10},{-30,30}})));
  Modelica.Electrical.Analog.Basic.Ground ground "Ground"
    annotation (Placement(transformation(extent={{-40,-20},{-20,0}})));
  Modelica.Mechanics.Translational.Components.Fixed base "Frame"
    annotation (Placement(transformation(extent={{-30,-60},{-10,-40}})));
  IT2Hysteresis.Components.PiezoActuator coarse(
    zeta=0.6,
    vStart=2,
    v(fixed=true),
    s_rel(fixed=true),
    v_rel(fixed=true)) "Coarse stack, on the frame"
    annotation (Placement(transformation(extent={{0,-40},{20,-20}})));
  IT2Hysteresis.Components.PiezoActuator fine(
    zeta=0.6,
    vStart=1,
    length=5e-3,
    c=6e7,
    m=2e-3,
    v(fixed=true),
    s_rel(fixed=true),
    v_rel(fixed=true)) "Fine stack, on the coarse one"
    annotation (Placement(transformation(extent={{40,-40},{60,-20}})));
  IT2Hysteresis.Components.PositionSensor sensor(offset=coarse.length + fine.length) "Position of the tip"
    annotation (Placement(transformation(extent={{20,-80},{40,-60}})));
equation
  connect(coarseCommand.y, coarseAmplifier.u)
    annotation (Line(points={{-69,60},{-52,60}}, color={0,0,127}));
  connect(fineCommand.y, fineAmplifier.u)
    annotation (Line(points={{-69,20},{-52,20}}, color={0,0,127}));
  connect(coarseAmplifier.p, coarse.p)
    annotation (Line(points={{-30,66},{4,66},{4,-20}}, color={0,0,255}));
  connect(coarseAmplifier.n, coarse.n)
    annotation (Line(points={{-30,54},{16,54},{16,-20}}, color={0,0,255}));
  connect(fineAmplifier.p, fine.p)
    annotation (Line(points={{-30,26},{44,26},{44,-20}}, color={0,0,255}));
  connect(fineAmplifier.n, fine.n)
    annotation (Line(points={{-30,14},{56,14},{56,-20}}, color={0,0,255}));
  connect(coarseAmplifier.n, ground.p)
    annotation (Line(points={{-30,54},{-24,54},{-24,0},{-30,0}}, color={0,0,255}));
  connect(fineAmplifier.n, ground.p)
    annotation (Line(points={{-30,14},{-30,0}}, color={0,0,255}));
  connect(base.flange, coarse.flange_a)
    annotation (Line(points={{-20,-50},{-20,-30},{0,-30}}, color={0,127,0}));
  connect(coarse.flange_b, fine.flange_a)
    annotation (Line(points={{20,-30},{40,-30}}, color={0,127,0}));
  connect(base.flange, sensor.flange_a)
    annotation (Line(points={{-20,-50},{-20,-70},{20,-70}}, color={0,127,0}));
  connect(fine.flange_b, sensor.flange_b)
    annotation (Line(points={{60,-30},{60,-70},{40,-70}}, color={0,127,0}));
  annotation (
    experiment(StopTime=0.1, Interval=2e-5, Tolerance=1e-6),
    Documentation(info="<html>
<p>
Two stacks in series: a coarse one moves a fine one, which moves a tip. Each has an amplifier and a hysteresis of its own; the tip goes
where both go together. The fine stack shakes the coarse one by the force that moves it, which is small beside the stiffness.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/TwoStages.png\" width=\"640\" alt=\"Travel of both stacks and of the tip, and both voltages, over time\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Coarse, fine and both",
          identifier="travel",
          preferred=true,
          plots={
            Plot(curves={Curve(y=sensor.y, legend="Tip"), Curve(y=coarse.s_rel, legend="Coarse stack"), Curve(y=fine.s_rel, legend="Fine stack")}),
            Plot(curves={Curve(y=coarse.v, legend="Voltage of the coarse stack"), Curve(y=fine.v, legend="Voltage of the fine stack")})})}));
end TwoStages;
