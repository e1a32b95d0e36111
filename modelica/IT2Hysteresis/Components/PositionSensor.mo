within IT2Hysteresis.Components;
model PositionSensor "Continuous displacement sensor with a bandwidth"
  parameter Modelica.Units.SI.Length offset(min=-10, max=10)=18e-3
    "Distance of the flanges that is read as 0";
  parameter Modelica.Units.SI.Frequency bandwidth(min=1e-3, max=1e9)=5e3
    "Frequency at which the reading has fallen to 1/sqrt(2)";
  Modelica.Mechanics.Translational.Interfaces.Flange_a flange_a "Flange that the displacement counts from"
    annotation (Placement(transformation(extent={{-110,-10},{-90,10}})));
  Modelica.Mechanics.Translational.Interfaces.Flange_b flange_b "Flange that moves"
    annotation (Placement(transformation(extent={{90,-10},{110,10}})));
  Modelica.Blocks.Interfaces.RealOutput y(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5) "Reading"
    annotation (Placement(transformation(
      extent={{-10,-10},{10,10}},
      rotation=270,
      origin={0,-110})));
protected
  final parameter Modelica.Units.SI.Time T=1/(2*Modelica.Constants.pi*bandwidth) "Time constant";
  Modelica.Units.SI.Length distance(displayUnit="um") "Distance of the flanges, less the offset";
  Modelica.Units.SI.Length reading(displayUnit="um", nominal=1e-5) "Reading";
initial equation
  reading = distance;
equation
  distance = flange_b.s - flange_a.s - offset;
  T*der(reading) = distance - reading;
  y = reading;
  flange_a.f = 0;
  flange_b.f = 0;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Line(points={{-90,0},{-30,0}}, color={0,127,0}),
        Line(points={{30,0},{90,0}}, color={0,127,0}),
        Rectangle(
          extent={{-30,50},{-10,-50}},
          lineColor={0,0,0},
          fillColor={192,192,192},
          fillPattern=FillPattern.Solid),
        Rectangle(
          extent={{10,50},{30,-50}},
          lineColor={0,0,0},
          fillColor={192,192,192},
          fillPattern=FillPattern.Solid),
        Line(points={{0,-100},{0,-60}}, color={0,0,127}),
        Text(
          extent={{10,-66},{150,-96}},
          textString="%bandwidth"),
        Text(
          extent={{-150,100},{150,60}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>
A capacitive or inductive sensor between two flanges: the reading follows their distance, less <code>offset</code>, by a first-order lag of
<code>bandwidth</code>. It is continuous, without noise, and takes no force; it begins settled. By default <code>offset</code> is the
length of the default <a href=\"modelica://IT2Hysteresis.Components.PiezoActuator\">actuator</a>. Beside a
<a href=\"modelica://IT2Hysteresis.Components.StrainGauge\">strain gauge</a> on the stack it shows how the platform moves.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PositionSensor;
