within IT2Hysteresis.Examples;
model TemperatureDrift "A stage that warms up, and a feedforward that is told the temperature"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 stage(
    sampleTime=0.5,
    initialDisplacement=5e-6,
    driftTemperatureCoefficient=3e-8) "Table 1 with 30 nm/K of drift";
  Modelica.Blocks.Sources.Sine reference(
    amplitude=0.5e-6,
    f=0.02,
    offset=5e-6) "Desired displacement"
    annotation (Placement(transformation(extent={{-90,40},{-70,60}})));
  Modelica.Blocks.Sources.Pulse heating(
    amplitude=2,
    width=50,
    period=240,
    nperiod=1,
    startTime=20) "Heat of the electronics, for 120 s"
    annotation (Placement(transformation(extent={{-90,-60},{-70,-40}})));
  Modelica.Thermal.HeatTransfer.Sources.PrescribedHeatFlow heat "The same as a heat flow"
    annotation (Placement(transformation(extent={{-60,-60},{-40,-40}})));
  Modelica.Thermal.HeatTransfer.Components.HeatCapacitor frame(C=20, T(start=293.15, fixed=true)) "Frame of the stage"
    annotation (Placement(transformation(extent={{-40,-50},{-20,-30}})));
  Modelica.Thermal.HeatTransfer.Components.ThermalConductor air(G=0.5) "To the air"
    annotation (Placement(transformation(extent={{-20,-60},{0,-40}})));
  Modelica.Thermal.HeatTransfer.Sources.FixedTemperature room(T=293.15) "Room"
    annotation (Placement(transformation(extent={{30,-60},{10,-40}})));
  Modelica.Blocks.Sources.RealExpression temperature(y=frame.T) "Temperature of the stage"
    annotation (Placement(transformation(extent={{-40,-10},{-20,10}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse without(parameters=stage) "Feedforward that takes it as 20 degC"
    annotation (Placement(transformation(extent={{-10,60},{10,80}})));
  IT2Hysteresis.Blocks.PureModelica.Plant drifting(parameters=stage, useTemperature=true) "Stage behind it"
    annotation (Placement(transformation(extent={{50,60},{70,80}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse inverse(parameters=stage, useTemperature=true) "Feedforward that is told the temperature"
    annotation (Placement(transformation(extent={{-10,20},{10,40}})));
  IT2Hysteresis.Blocks.PureModelica.Plant plant(parameters=stage, useTemperature=true) "Stage behind it"
    annotation (Placement(transformation(extent={{50,20},{70,40}})));
equation
  connect(heating.y, heat.Q_flow)
    annotation (Line(points={{-69,-50},{-60,-50}}, color={0,0,127}));
  connect(heat.port, frame.port)
    annotation (Line(points={{-40,-50},{-30,-50}}, color={191,0,0}));
  connect(frame.port, air.port_a)
    annotation (Line(points={{-30,-50},{-20,-50}}, color={191,0,0}));
  connect(air.port_b, room.port)
    annotation (Line(points={{0,-50},{10,-50}}, color={191,0,0}));
  connect(reference.y, without.reference)
    annotation (Line(points={{-69,50},{-40,50},{-40,70},{-12,70}}, color={0,0,127}));
  connect(reference.y, inverse.reference)
    annotation (Line(points={{-69,50},{-40,50},{-40,30},{-12,30}}, color={0,0,127}));
  connect(without.voltage, drifting.voltage)
    annotation (Line(points={{11,70},{48,70}}, color={0,0,127}));
  connect(inverse.voltage, plant.voltage)
    annotation (Line(points={{11,30},{48,30}}, color={0,0,127}));
  connect(temperature.y, inverse.temperature)
    annotation (Line(points={{-19,0},{6,0},{6,18}}, color={0,0,127}));
  connect(temperature.y, plant.temperature)
    annotation (Line(points={{-19,0},{66,0},{66,18}}, color={0,0,127}));
  connect(temperature.y, drifting.temperature)
    annotation (Line(points={{-19,0},{40,0},{40,54},{66,54},{66,58}}, color={0,0,127}));
  annotation (
    experiment(StopTime=300, Interval=0.5, Tolerance=1e-6),
    Documentation(info="<html>
<p>
Electronics of 2 W heat the frame of a stage for two minutes, by 4 K. The stage drifts by 30 nm/K, the effect
<a href=\"modelica://IT2Hysteresis.Functions.Effects.drift\">drift</a>: a feedforward that is not told the temperature ends 0.11 &#181;m off. One that
has the input <code>temperature</code> takes the drift back at every tick.
</p>
<p>
The actuator with pins and flanges takes the temperature of its heat port, see
<a href=\"modelica://IT2Hysteresis.Components.PiezoActuator\">PiezoActuator</a>.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/TemperatureDrift.png\" width=\"640\" alt=\"Displacement with and without knowledge of the temperature, and the temperature, over 300 s\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Temperature and drift",
          identifier="drift",
          preferred=true,
          plots={
            Plot(curves={Curve(y=reference.y, legend="Reference"), Curve(y=drifting.displacement, legend="Temperature not known"), Curve(y=plant.displacement, legend="Temperature known")}),
            Plot(curves={Curve(y=frame.T, legend="Temperature of the frame")})})}));
end TemperatureDrift;
