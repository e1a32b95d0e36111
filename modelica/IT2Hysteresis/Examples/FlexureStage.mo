within IT2Hysteresis.Examples;
model FlexureStage "Actuator, amplifier and gauge: a mass moved against a spring through a flexure"
  extends Modelica.Icons.Example;
  Modelica.Blocks.Sources.Sine command(
    amplitude=3.3,
    f=25,
    phase=-Modelica.Constants.pi/2,
    offset=3.5) "Voltage at the amplifier's input, 0.2 to 6.8 V"
    annotation (Placement(transformation(extent={{-80,30},{-60,50}})));
  IT2Hysteresis.Components.VoltageAmplifier amplifier(vStart=actuator.vStart) "Amplifier"
    annotation (Placement(transformation(extent={{-40,30},{-20,50}})));
  Modelica.Electrical.Analog.Basic.Ground ground
    annotation (Placement(transformation(extent={{-20,10},{0,30}})));
  Modelica.Mechanics.Translational.Components.Fixed base "Frame at the base of the actuator"
    annotation (Placement(transformation(extent={{-30,-30},{-10,-10}})));
  IT2Hysteresis.Components.PiezoActuator actuator(
    zeta=0.6,
    vStart=3,
    v(fixed=true),
    s_rel(fixed=true),
    v_rel(fixed=true)) "Stack"
    annotation (Placement(transformation(extent={{0,-10},{20,10}})));
  Modelica.Mechanics.Translational.Components.SpringDamper flexure(
    c=5e7,
    d=300,
    s_rel0=0) "Flexure between stack and platform"
    annotation (Placement(transformation(extent={{30,-10},{50,10}})));
  Modelica.Mechanics.Translational.Components.Mass platform(
    m=0.2,
    L=0,
    s(start=actuator.length + 1.0762e-6, fixed=true),
    v(start=0, fixed=true)) "Platform"
    annotation (Placement(transformation(extent={{56,-10},{76,10}})));
  Modelica.Mechanics.Translational.Components.SpringDamper spring(
    c=2e6,
    d=50,
    s_rel0=10e-3) "Spring that the platform is pushed against"
    annotation (Placement(transformation(extent={{80,-10},{100,10}})));
  Modelica.Mechanics.Translational.Components.Fixed wall(s0=actuator.length + 10e-3) "Frame"
    annotation (Placement(transformation(extent={{90,-40},{110,-20}})));
  IT2Hysteresis.Components.StrainGauge gauge(
    parameters=actuator.stage,
    offset=actuator.length,
    y(start=1.0762e-6)) "Strain gauge on the stack"
    annotation (Placement(transformation(extent={{0,-50},{20,-30}})));
equation
  connect(command.y, amplifier.u)
    annotation (Line(points={{-59,40},{-42,40}}, color={0,0,127}));
  connect(amplifier.p, actuator.p)
    annotation (Line(points={{-20,46},{4,46},{4,10}}, color={0,0,255}));
  connect(amplifier.n, actuator.n)
    annotation (Line(points={{-20,34},{16,34},{16,10}}, color={0,0,255}));
  connect(amplifier.n, ground.p)
    annotation (Line(points={{-20,34},{-10,34},{-10,30}}, color={0,0,255}));
  connect(base.flange, actuator.flange_a)
    annotation (Line(points={{-20,-20},{-20,0},{0,0}}, color={0,127,0}));
  connect(actuator.flange_b, flexure.flange_a)
    annotation (Line(points={{20,0},{30,0}}, color={0,127,0}));
  connect(flexure.flange_b, platform.flange_a)
    annotation (Line(points={{50,0},{56,0}}, color={0,127,0}));
  connect(actuator.flange_a, gauge.flange_a)
    annotation (Line(points={{0,0},{0,-40}}, color={0,127,0}));
  connect(actuator.flange_b, gauge.flange_b)
    annotation (Line(points={{20,0},{20,-40}}, color={0,127,0}));
  connect(platform.flange_b, spring.flange_a)
    annotation (Line(points={{76,0},{80,0}}, color={0,127,0}));
  connect(spring.flange_b, wall.flange)
    annotation (Line(points={{100,0},{100,-30}}, color={0,127,0}));
  annotation (
    experiment(StopTime=0.12, Interval=2e-5, Tolerance=1e-6),
    Diagram(coordinateSystem(preserveAspectRatio=true, extent={{-100,-80},{120,80}})),
    Documentation(info="<html>
<p>
An amplifier drives a stack, which moves a platform of 0.2 kg through a flexure, against a spring to the frame. The spring
takes a part of the stroke: about the ratio of its stiffness to that of the stack. The platform oscillates with the
stiffness of stack and flexure, excited by the steps of the sampled free stroke.
</p>
<p>
The amplifier's current is what charges the capacitance and moves the stack; it ripples with those steps. A strain gauge reads the stack's displacement
with 16 bits and 5 nm of noise.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/FlexureStage.png\" width=\"640\" alt=\"Displacement of stack and platform, voltage and current over time, and displacement over voltage\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Displacement",
          identifier="displacement",
          preferred=true,
          plots={
            Plot(curves={Curve(y=actuator.s_rel, legend="Stack"), Curve(y=gauge.y, legend="Gauge")}),
            Plot(curves={Curve(y=platform.s, legend="Position of the platform")}),
            Plot(curves={Curve(y=actuator.v, legend="Voltage")}),
            Plot(curves={Curve(y=actuator.i, legend="Current")})}),
        Figure(
          title="Hysteresis of the loaded stage",
          identifier="loop",
          plots={
            Plot(curves={Curve(x=actuator.v, y=actuator.s_rel, legend="Displacement over voltage")})})}));
end FlexureStage;
