within IT2Hysteresis.Examples;
model FMUStage "Inverse, amplifier and actuator, with the FMUs"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 known(initialDisplacement=0.7e-6) "Set of the inverse and of the stack";
  Modelica.Blocks.Sources.Sine reference(
    amplitude=6e-6,
    f=20,
    phase=-Modelica.Constants.pi/2,
    offset=6.7e-6) "Desired displacement"
    annotation (Placement(transformation(extent={{-100,30},{-80,50}})));
  IT2Hysteresis.Blocks.Inverse inverse(parameters=known) "Feedforward, by the FMU IT2Inverse"
    annotation (Placement(transformation(extent={{-70,30},{-50,50}})));
  IT2Hysteresis.Components.VoltageAmplifier amplifier(k=1, vStart=actuator.vStart) "Amplifier; the inverse asks for volts at the stack"
    annotation (Placement(transformation(extent={{-40,30},{-20,50}})));
  Modelica.Electrical.Analog.Basic.Ground ground "Ground"
    annotation (Placement(transformation(extent={{-20,10},{0,30}})));
  Modelica.Mechanics.Translational.Components.Fixed base "Frame at the base of the actuator"
    annotation (Placement(transformation(extent={{-30,-30},{-10,-10}})));
  IT2Hysteresis.Components.PiezoActuator actuator(
    redeclare block FreeStroke = IT2Hysteresis.Blocks.Plant,
    stage=known,
    zeta=0.6,
    v(fixed=true),
    s_rel(fixed=true),
    v_rel(fixed=true)) "Stack; its free stroke by the FMU IT2Plant"
    annotation (Placement(transformation(extent={{0,-10},{20,10}})));
  IT2Hysteresis.Components.FlexureGuide guide(ratio=3, c=2e6) "Lever of 3 : 1, preloaded"
    annotation (Placement(transformation(extent={{40,-10},{60,10}})));
  IT2Hysteresis.Components.StrainGauge gauge(
    parameters=known,
    offset=actuator.length,
    y(start=0.7e-6)) "Strain gauge on the stack"
    annotation (Placement(transformation(extent={{0,-50},{20,-30}})));
  IT2Hysteresis.Components.PositionSensor sensor(offset=actuator.length + 0.7e-6) "Position of the platform, from where it begins"
    annotation (Placement(transformation(extent={{40,-50},{60,-30}})));
equation
  connect(reference.y, inverse.reference)
    annotation (Line(points={{-79,40},{-72,40}}, color={0,0,127}));
  connect(inverse.voltage, amplifier.u)
    annotation (Line(points={{-49,40},{-42,40}}, color={0,0,127}));
  connect(amplifier.p, actuator.p)
    annotation (Line(points={{-20,46},{4,46},{4,10}}, color={0,0,255}));
  connect(amplifier.n, actuator.n)
    annotation (Line(points={{-20,34},{16,34},{16,10}}, color={0,0,255}));
  connect(amplifier.n, ground.p)
    annotation (Line(points={{-20,34},{-10,34},{-10,30}}, color={0,0,255}));
  connect(base.flange, actuator.flange_a)
    annotation (Line(points={{-20,-20},{-20,0},{0,0}}, color={0,127,0}));
  connect(actuator.flange_b, guide.flange_a)
    annotation (Line(points={{20,0},{40,0}}, color={0,127,0}));
  connect(actuator.flange_a, gauge.flange_a)
    annotation (Line(points={{0,0},{0,-40}}, color={0,127,0}));
  connect(actuator.flange_b, gauge.flange_b)
    annotation (Line(points={{20,0},{20,-40}}, color={0,127,0}));
  connect(base.flange, sensor.flange_a)
    annotation (Line(points={{-20,-20},{-20,-70},{40,-70},{40,-40}}, color={0,127,0}));
  connect(guide.flange_b, sensor.flange_b)
    annotation (Line(points={{60,0},{60,-40}}, color={0,127,0}));
  annotation (
    experiment(StopTime=0.12, Interval=2e-5, Tolerance=1e-6),
    Diagram(coordinateSystem(preserveAspectRatio=true, extent={{-110,-80},{100,80}})),
    Documentation(info="<html>
<p>
The reference goes through the FMU <code>IT2Inverse</code> and an amplifier to a stack, whose free stroke the FMU
<code>IT2Plant</code> computes: what one builds to test a feedforward in a machine. A preloaded guide with a lever of 3 : 1 takes a tenth of
the stroke, the ratio of its stiffness to that of the stack, and makes three times the rest of it. The strain gauge reads the stack, the position
sensor the platform.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/FMUStage.png\" width=\"640\" alt=\"Reference and strain gauge, platform, and voltage over time\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Stack and platform",
          identifier="tracking",
          preferred=true,
          plots={
            Plot(curves={Curve(y=reference.y, legend="Reference"), Curve(y=gauge.y, legend="Strain gauge")}),
            Plot(curves={Curve(y=sensor.y, legend="Platform")}),
            Plot(curves={Curve(y=amplifier.v, legend="Voltage")})})}));
end FMUStage;
