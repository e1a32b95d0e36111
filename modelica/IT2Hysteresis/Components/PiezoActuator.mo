within IT2Hysteresis.Components;
model PiezoActuator "Stack actuator with hysteresis: electrical pins, translational flanges"
  extends Modelica.Electrical.Analog.Interfaces.ConditionalHeatPort(T=293.15);
  replaceable block FreeStroke = IT2Hysteresis.Blocks.PureModelica.Plant
    constrainedby IT2Hysteresis.Interfaces.PartialPlant "Realisation of the free stroke"
    annotation (choicesAllMatching=true);
  replaceable record Stage = IT2Hysteresis.Parameters.Table1
    constrainedby IT2Hysteresis.Parameters.Base "Parameter set of the free stroke"
    annotation (choicesAllMatching=true);
  parameter Stage stage "Parameters of the free stroke";
  parameter Modelica.Units.SI.TranslationalSpringConstant c(min=0, max=1e12)=2e7
    "Stiffness at constant voltage"
    annotation (Dialog(group="Mechanics"));
  parameter Modelica.Units.SI.Mass m(min=1e-9, max=1e3)=5e-3 "Mass that moves with flange_b"
    annotation (Dialog(group="Mechanics"));
  parameter Real zeta(unit="1", min=0, max=10)=0.05 "Damping of stiffness and mass, of critical"
    annotation (Dialog(group="Mechanics"));
  parameter Modelica.Units.SI.Length length(min=0, max=10)=18e-3 "Length at displacement 0"
    annotation (Dialog(group="Mechanics"));
  parameter Modelica.Units.SI.Capacitance C(min=1e-15, max=1)=1.5e-6
    "Capacitance with blocked flanges"
    annotation (Dialog(group="Electrics"));
  parameter Real alpha(
    unit="N/V",
    min=0,
    max=1e6)=c*stage.displacementMax/stage.voltageMax
    "Force per voltage with blocked flanges, and charge per displacement"
    annotation (Dialog(group="Electrics"));
  parameter Modelica.Units.SI.Conductance G(min=0, max=1)=0 "Conductance of the insulation"
    annotation (Dialog(group="Electrics"));
  parameter Modelica.Units.SI.Voltage vStart(min=-2000, max=2000)=
    IT2Hysteresis.Functions.Effects.saturation(
      stage.voltageMin,
      stage.voltageMax,
      natural.voltageRest) "Voltage at the start, at which the actuator rests"
    annotation (Dialog(tab="Initialization"));
  parameter StateSelect stateSelect=StateSelect.prefer "Priority to use s_rel and v_rel as states"
    annotation (HideResult=true, Dialog(tab="Advanced"));
  final parameter Modelica.Units.SI.Force blockedForce=c*stage.displacementMax
    "Force at the end of the range with blocked flanges";
  Modelica.Electrical.Analog.Interfaces.PositivePin p "Positive pin"
    annotation (Placement(transformation(extent={{-70,90},{-50,110}})));
  Modelica.Electrical.Analog.Interfaces.NegativePin n "Negative pin"
    annotation (Placement(transformation(extent={{50,90},{70,110}})));
  Modelica.Mechanics.Translational.Interfaces.Flange_a flange_a "Base"
    annotation (Placement(transformation(extent={{-110,-10},{-90,10}})));
  Modelica.Mechanics.Translational.Interfaces.Flange_b flange_b "Tip"
    annotation (Placement(transformation(extent={{90,-10},{110,10}})));
  Modelica.Units.SI.Voltage v(start=vStart, nominal=100) "Voltage between the pins"
    annotation (Dialog(tab="Initialization", showStartAttribute=true));
  Modelica.Units.SI.Current i "Current into the positive pin";
  Modelica.Units.SI.Charge q(nominal=1e-4) "Charge drawn";
  Modelica.Units.SI.Length s_rel(
    start=rest.displacementRest + IT2Hysteresis.Functions.Effects.drift(
      stage.driftTemperatureCoefficient,
      stage.driftRate,
      T,
      0),
    stateSelect=stateSelect,
    displayUnit="um",
    nominal=1e-5) "Displacement: elongation beyond length"
    annotation (Dialog(tab="Initialization", showStartAttribute=true));
  Modelica.Units.SI.Velocity v_rel(start=0, stateSelect=stateSelect, nominal=1e-2) "Rate of the elongation"
    annotation (Dialog(tab="Initialization", showStartAttribute=true));
  Modelica.Units.SI.Force f(nominal=100) "Force that the stack pushes with";
protected
  final parameter Modelica.Units.SI.TranslationalDampingConstant d=2*zeta*sqrt(c*m)
    "Damping constant";
  Modelica.Units.SI.Velocity v_b(nominal=1e-2) "Velocity of flange_b";
  IT2Hysteresis.Internal.Constants natural(parameters=stage) "At rest at stage.initialDisplacement";
  IT2Hysteresis.Internal.Constants rest(
    parameters=stage,
    restsAtVoltage=true,
    restVoltage=vStart) "At rest at vStart";
  FreeStroke stroke(
    parameters=stage,
    initialDisplacement=rest.displacementRest,
    useTemperature=true) "Displacement without force";
  Modelica.Blocks.Sources.RealExpression temperature(y(unit="K")=T_heatPort) "Temperature of the stack";
equation
  connect(temperature.y, stroke.temperature);
  v = p.v - n.v;
  i = p.i;
  0 = p.i + n.i;
  q = C*v + alpha*s_rel;
  i = C*der(v) + alpha*v_rel + G*v;
  stroke.voltage = v;
  s_rel = flange_b.s - flange_a.s - length;
  v_rel = der(s_rel);
  v_b = der(flange_b.s);
  f = c*(stroke.displacement - s_rel) - d*v_rel;
  m*der(v_b) = f + flange_b.f;
  flange_a.f = f;
  LossPower = (alpha*v - c*stroke.displacement)*v_rel + d*v_rel^2 + G*v^2;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-90,40},{90,-40}},
          lineColor={0,127,0},
          fillColor={224,240,224},
          fillPattern=FillPattern.Solid),
        Line(points={{-54,40},{-54,-40}}, color={0,127,0}),
        Line(points={{-18,40},{-18,-40}}, color={0,127,0}),
        Line(points={{18,40},{18,-40}}, color={0,127,0}),
        Line(points={{54,40},{54,-40}}, color={0,127,0}),
        Line(points={{-60,90},{-60,40}}, color={0,0,255}),
        Line(points={{60,90},{60,40}}, color={0,0,255}),
        Line(
          points={{-60,-90},{20,-90},{60,-56}},
          color={28,108,200},
          smooth=Smooth.Bezier),
        Line(
          points={{60,-56},{-20,-56},{-60,-90}},
          color={28,108,200},
          smooth=Smooth.Bezier),
        Text(
          extent={{-150,-110},{150,-150}},
          textString="%name",
          textColor={0,0,255}),
        Text(
          extent={{-150,-155},{150,-185}},
          textString="c=%c")}),
    Documentation(info="<html>
<p>
A stack between two flanges. The <a href=\"modelica://IT2Hysteresis.Blocks\">plant</a> gives its free stroke y, the displacement
that the voltage would make without any force, once in a sample time. Stiffness, damping and mass make a mechanical
component of it:
</p>
<p>
f = c (y - s<sub>rel</sub>) - d ds<sub>rel</sub>/dt, with d = 2 &#950; &#8730;(c m)<br/>
m d<sup>2</sup>s<sub>b</sub>/dt<sup>2</sup> = f + f<sub>b</sub>
</p>
<p>
With blocked flanges and at <code>displacementMax</code> it pushes with <code>blockedForce</code> = c <code>displacementMax</code>; a force
of that size takes all of the stroke.
</p>
<p>
The pins see the capacitance C of the blocked stack and the charge that its motion draws:
</p>
<p>q = C v + &#945; s<sub>rel</sub>, i = dq/dt + G v.</p>
<p>
&#945; is by default the blocked force per voltage of the whole range; that makes the component reciprocal, as a piezo is. A
current limit of the amplifier therefore limits the speed of the actuator.
</p>
<p>
The loss (&#945; v - c y) v<sub>rel</sub> + d v<sub>rel</sub><sup>2</sup> + G v<sup>2</sup> leaves through the heat port, if
<code>useHeatPort</code>: it is what electrical energy goes neither into the capacitance, nor into the stiffness, nor out of the flanges. Over a
period its first part is &#945; times the area of the loop; within one it also takes and gives back. The temperature of
the heat port, or <code>T</code> without one, acts through the effect drift, which is off unless parameterised.
</p>
<h4>Start</h4>
<p>
The actuator begins at rest at <code>vStart</code>, without force. By default that is the voltage within
<code>voltageMin</code> ... <code>voltageMax</code> that comes nearest to holding it at <code>stage.initialDisplacement</code>: for
<a href=\"modelica://IT2Hysteresis.Parameters.Table1\">Table1</a> it is 0 V, where the actuator is 0.58 &#181;m long. Give an amplifier
the same voltage at its start. As in <code>Modelica.Mechanics</code>, <code>s_rel</code> and <code>v_rel</code> are preferred states; their start
values are fixed by whoever uses the actuator, and a guess otherwise.
</p>
<p>
The mechanics are here: leave the effects load and resonance out of the parameter set. The free stroke is computed in
pure Modelica; redeclare <code>FreeStroke</code> as <a href=\"modelica://IT2Hysteresis.Blocks.Plant\">Blocks.Plant</a> to have it by the
FMU.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PiezoActuator;
