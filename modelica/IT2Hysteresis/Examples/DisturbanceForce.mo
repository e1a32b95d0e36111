within IT2Hysteresis.Examples;
model DisturbanceForce "A force on the platform: feedforward does not see it, feedback does"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 known(initialDisplacement=0.7e-6) "What the inverse knows";
  Modelica.Blocks.Sources.Sine reference(
    amplitude=4e-6,
    f=10,
    phase=-Modelica.Constants.pi/2,
    offset=4.7e-6) "Desired displacement"
    annotation (Placement(transformation(extent={{-170,30},{-150,50}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse inverse(parameters=known) "Feedforward"
    annotation (Placement(transformation(extent={{-130,50},{-110,70}})));
  IT2Hysteresis.Components.SampledPI controller(
    parameters=known,
    k=1.5e6,
    Ti=2e-3) "Feedback"
    annotation (Placement(transformation(extent={{-130,-10},{-110,10}})));
  Modelica.Blocks.Math.Add total "Voltage"
    annotation (Placement(transformation(extent={{-80,30},{-60,50}})));
  IT2Hysteresis.Components.VoltageAmplifier amplifier(k=1, vStart=actuator.vStart) "Amplifier"
    annotation (Placement(transformation(extent={{-40,30},{-20,50}})));
  Modelica.Electrical.Analog.Basic.Ground ground
    annotation (Placement(transformation(extent={{-20,10},{0,30}})));
  Modelica.Mechanics.Translational.Components.Fixed base "Frame at the base of the actuator"
    annotation (Placement(transformation(extent={{-30,-30},{-10,-10}})));
  IT2Hysteresis.Components.PiezoActuator actuator(
    stage=known,
    zeta=0.6,
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
    s(start=actuator.length + 0.7e-6, fixed=true),
    v(start=0, fixed=true)) "Platform"
    annotation (Placement(transformation(extent={{56,-10},{76,10}})));
  Modelica.Blocks.Sources.Pulse pulse(
    amplitude=-40,
    width=50,
    period=0.1,
    nperiod=1,
    startTime=0.125) "Force, from 0.125 s to 0.175 s"
    annotation (Placement(transformation(extent={{60,30},{80,50}})));
  Modelica.Mechanics.Translational.Sources.Force disturbance "Force on the platform"
    annotation (Placement(transformation(extent={{-10,-10},{10,10}}, rotation=180, origin={100,0})));
  IT2Hysteresis.Components.StrainGauge gauge(
    parameters=known,
    offset=actuator.length,
    y(start=0.7e-6)) "Strain gauge on the stack"
    annotation (Placement(transformation(extent={{0,-50},{20,-30}})));
equation
  connect(reference.y, inverse.reference)
    annotation (Line(points={{-149,40},{-140,40},{-140,60},{-132,60}}, color={0,0,127}));
  connect(reference.y, controller.reference)
    annotation (Line(points={{-149,40},{-140,40},{-140,6},{-132,6}}, color={0,0,127}));
  connect(inverse.voltage, total.u1)
    annotation (Line(points={{-109,60},{-96,60},{-96,46},{-82,46}}, color={0,0,127}));
  connect(controller.y, total.u2)
    annotation (Line(points={{-109,0},{-96,0},{-96,34},{-82,34}}, color={0,0,127}));
  connect(total.y, amplifier.u)
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
  connect(gauge.y, controller.measured)
    annotation (Line(points={{10,-51},{10,-70},{-140,-70},{-140,-6},{-132,-6}}, color={0,0,127}));
  connect(pulse.y, disturbance.f)
    annotation (Line(points={{81,40},{120,40},{120,0},{112,0}}, color={0,0,127}));
  connect(disturbance.flange, platform.flange_b)
    annotation (Line(points={{90,0},{76,0}}, color={0,127,0}));
  annotation (
    experiment(StopTime=0.25, Interval=1e-4, Tolerance=1e-6),
    Diagram(coordinateSystem(preserveAspectRatio=true, extent={{-180,-80},{140,80}})),
    Documentation(info="<html>
<p>
A stack follows a reference, by the inverse and a PI controller that reads the strain gauge. From 0.125 s to 0.175 s a force of
40 N presses on the platform and shortens the stack by force over stiffness, 2 &#181;m. The inverse cannot know; the
controller raises the voltage until the displacement is back, and takes it away again when the force ends.
</p>
<p>
Before the force, the controller has to correct only what inverse and amplifier leave: the mechanics and the amplifier's
lag, which the parameter set of the inverse does not hold.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/DisturbanceForce.png\" width=\"640\" alt=\"Reference and displacement, correction and force over time\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="A force and its correction",
          identifier="force",
          preferred=true,
          plots={
            Plot(curves={Curve(y=reference.y, legend="Reference"), Curve(y=actuator.s_rel, legend="Displacement")}),
            Plot(curves={Curve(y=controller.y, legend="Correction")}),
            Plot(curves={Curve(y=pulse.y, legend="Force")})})}));
end DisturbanceForce;
