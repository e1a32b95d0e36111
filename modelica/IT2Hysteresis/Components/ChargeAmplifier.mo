within IT2Hysteresis.Components;
model ChargeAmplifier "Amplifier that gives a charge instead of a voltage"
  parameter Real k(
    unit="C/V",
    min=-1,
    max=1)=2e-5 "Charge per input voltage";
  parameter Modelica.Units.SI.Voltage uStart(min=-1e4, max=1e4)=0
    "Input at the start, which the charge that is there then belongs to"
    annotation (Dialog(tab="Initialization"));
  parameter Modelica.Units.SI.Voltage vMin(min=-2000, max=2000)=0 "Lowest voltage";
  parameter Modelica.Units.SI.Voltage vMax(min=-2000, max=2000)=150 "Highest voltage";
  parameter Modelica.Units.SI.Current iMax(min=0, max=1e3)=0.3 "Largest current, of either sign";
  parameter Modelica.Units.SI.Resistance R(min=1e-6, max=1e9)=10 "Resistance at the limits of the voltage";
  parameter Modelica.Units.SI.Time T(min=1e-9, max=1e3, displayUnit="ms")=5e-5
    "Time constant that the charge follows with";
  Modelica.Blocks.Interfaces.RealInput u(unit="V") "Charge that is wanted, divided by k"
    annotation (Placement(transformation(extent={{-140,-20},{-100,20}})));
  Modelica.Electrical.Analog.Interfaces.PositivePin p "Positive pin"
    annotation (Placement(transformation(extent={{90,50},{110,70}})));
  Modelica.Electrical.Analog.Interfaces.NegativePin n "Negative pin"
    annotation (Placement(transformation(extent={{90,-70},{110,-50}})));
  Modelica.Units.SI.Voltage v(nominal=100) "Voltage at the pins";
  Modelica.Units.SI.Current i "Current out of the positive pin";
  Modelica.Units.SI.Charge q(
    start=0,
    fixed=true,
    nominal=1e-4) "Charge given since the start";
protected
  Modelica.Units.SI.Charge wanted(nominal=1e-4) "Charge that is wanted";
equation
  wanted = k*(u - uStart);
  i = min(max((wanted - q)/T, max(-iMax, (vMin - v)/R)), min(iMax, (vMax - v)/R));
  der(q) = i;
  v = p.v - n.v;
  p.i = -i;
  n.i = i;
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
          extent={{-58,28},{20,-28}},
          textString="Q"),
        Text(
          extent={{-150,-110},{150,-140}},
          textString="k=%k"),
        Text(
          extent={{-150,150},{150,110}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>
The charge k (u - u<sub>start</sub>) flows into what is connected, beside the charge that is there at the start: with a time constant, a
current of no more than <code>iMax</code>, and only as long as the voltage is between <code>vMin</code> and <code>vMax</code>. The
hysteresis of a stack is between voltage and displacement; over the charge its displacement is much straighter. What leaks away
through an insulation is not given again, so that the displacement sinks slowly, as with any charge amplifier.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end ChargeAmplifier;
