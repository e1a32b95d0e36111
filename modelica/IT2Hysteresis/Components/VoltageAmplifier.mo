within IT2Hysteresis.Components;
model VoltageAmplifier "Amplifier with limits of voltage, current and slew rate"
  parameter Real k(unit="1", min=-1e4, max=1e4)=15 "Gain";
  parameter Modelica.Units.SI.Voltage vMin(min=-2000, max=2000)=0 "Lowest voltage";
  parameter Modelica.Units.SI.Voltage vMax(min=-2000, max=2000)=150 "Highest voltage";
  parameter Modelica.Units.SI.Current iMax(min=0, max=1e3)=0.3 "Largest current, of either sign";
  parameter Modelica.Units.SI.Resistance R(min=1e-6, max=1e9)=10 "Output resistance";
  parameter Modelica.Units.SI.Time T(min=1e-9, max=1e3, displayUnit="ms")=2e-5
    "Time constant of the first-order lag";
  parameter Real slewRate(
    final quantity="SlewRate",
    final unit="V/s",
    min=1e-6,
    max=1e12)=1e6 "Largest rate of the voltage without a load";
  parameter Modelica.Units.SI.Voltage vStart(min=-2000, max=2000)=0 "Voltage at the start"
    annotation (Dialog(tab="Initialization"));
  Modelica.Blocks.Interfaces.RealInput u(unit="V") "Voltage that is amplified"
    annotation (Placement(transformation(extent={{-140,-20},{-100,20}})));
  Modelica.Electrical.Analog.Interfaces.PositivePin p "Positive pin"
    annotation (Placement(transformation(extent={{90,50},{110,70}})));
  Modelica.Electrical.Analog.Interfaces.NegativePin n "Negative pin"
    annotation (Placement(transformation(extent={{90,-70},{110,-50}})));
  Modelica.Units.SI.Voltage v(nominal=100) "Voltage at the pins";
  Modelica.Units.SI.Current i "Current out of the positive pin";
  Modelica.Units.SI.Power power "Power delivered";
protected
  Modelica.Units.SI.Voltage wanted "Amplified voltage within the limits";
  Modelica.Units.SI.Voltage source(start=vStart, fixed=true, nominal=100) "Voltage in front of the output resistance";
equation
  wanted = min(max(k*u, vMin), vMax);
  der(source) = min(max((wanted - source)/T, -slewRate), slewRate);
  i = min(max((source - v)/R, -iMax), iMax);
  v = p.v - n.v;
  p.i = -i;
  n.i = i;
  power = v*i;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-100,100},{100,-100}},
          lineColor={0,0,127},
          fillColor={255,255,255},
          fillPattern=FillPattern.Solid),
        Polygon(
          points={{-60,70},{-60,-70},{60,0},{-60,70}},
          lineColor={0,0,255},
          fillColor={235,240,255},
          fillPattern=FillPattern.Solid),
        Line(points={{60,0},{80,0},{80,60},{90,60}}, color={0,0,255}),
        Line(points={{-100,0},{-60,0}}, color={0,0,127}),
        Text(
          extent={{-58,20},{30,-20}},
          textString="k=%k"),
        Text(
          extent={{-150,150},{150,110}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>
The input is amplified, kept between <code>vMin</code> and <code>vMax</code>, and reaches the output through a first-order lag and a
resistance. It rises and falls by no more than <code>slewRate</code>; the current is limited to <code>iMax</code>, which at a capacitance,
as that of a piezo, is a slew limit of <code>iMax</code>/C. Gain and voltages are those of the paper's rig, which takes 0 ... 10 V and
gives 0 ... 150 V; the other defaults are those of a bench amplifier.
</p>
<p>
A parameter set with the effects saturation, slew or lag describes the amplifier too; use one of the two.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end VoltageAmplifier;
