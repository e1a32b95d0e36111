within IT2Hysteresis.Components;
model FlexureGuide "Preloaded flexure guide with a lever"
  extends Modelica.Mechanics.Translational.Interfaces.PartialElementaryTwoFlangesAndSupport2;
  parameter Real ratio(unit="1", min=-1e3, max=1e3)=1 "Travel of flange_b per travel of flange_a";
  parameter Modelica.Units.SI.TranslationalSpringConstant c(min=0, max=1e12)=5e6 "Stiffness, at flange_a";
  parameter Modelica.Units.SI.Mass m(min=1e-9, max=1e3)=0.05 "Mass that moves, as felt at flange_a";
  parameter Real zeta(unit="1", min=0, max=10)=0.3 "Damping of stiffness and mass, of critical";
  parameter Modelica.Units.SI.Length length(min=-10, max=10)=0 "Distance of the flanges where the guide is relaxed";
  parameter Modelica.Units.SI.Force preload(min=0, max=1e6)=200 "Force that presses on the stack as it is mounted";
  parameter Boolean restsAtStart=true
    "= true, if the guide is as it is mounted where a simulation begins, otherwise where s_a is s_mounted"
    annotation (Dialog(tab="Initialization"), choices(checkBox=true));
  parameter Modelica.Units.SI.Length s_mounted(min=-10, max=10)=18e-3 "Distance of flange_a to the support, as mounted"
    annotation (Dialog(tab="Initialization", enable=not restsAtStart));
  Modelica.Units.SI.Length x(displayUnit="um", nominal=1e-5) "Travel of flange_a";
  Modelica.Units.SI.Velocity v(nominal=1e-2) "Its rate";
  Modelica.Units.SI.Force stackForce "Force that presses on what is at flange_a";
protected
  discrete Boolean pulled(start=false, fixed=true) "The stack was pulled: said once";
  parameter Modelica.Units.SI.Length s_0(fixed=false) "Where the travel counts from";
  final parameter Modelica.Units.SI.TranslationalDampingConstant d=2*zeta*sqrt(c*m) "Damping constant";
initial equation
  s_0 = if restsAtStart then s_a else s_mounted;
equation
  x = s_a - s_0;
  v = der(x);
  s_b = s_0 + length + ratio*x;
  m*der(v) = flange_a.f + ratio*flange_b.f - c*x - d*v;
  stackForce = preload + flange_a.f;
  when stackForce < 0 then
    pulled = true;
    assert(pre(pulled), getInstanceName() + ": the stack is pulled, by more than the preload of "
      + String(preload, significantDigits=6) + " N; a stack must not be. This is said once.", AssertionLevel.warning);
  end when;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-60,40},{60,-40}},
          lineColor={0,0,0},
          fillColor={224,224,224},
          fillPattern=FillPattern.Solid),
        Line(points={{-100,0},{-60,0}}, color={0,127,0}),
        Line(points={{60,0},{100,0}}, color={0,127,0}),
        Line(points={{-50,40},{-50,80}}, color={0,0,0}, thickness=0.5),
        Line(points={{50,40},{50,80}}, color={0,0,0}, thickness=0.5),
        Line(points={{-50,-40},{-50,-80}}, color={0,0,0}, thickness=0.5),
        Line(points={{50,-40},{50,-80}}, color={0,0,0}, thickness=0.5),
        Line(points={{-80,80},{80,80}}, color={0,127,0}),
        Line(points={{-80,-80},{80,-80}}, color={0,127,0}),
        Text(
          extent={{-58,24},{58,-24}},
          textString="%ratio : 1"),
        Text(
          extent={{-150,130},{150,90}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>
A platform on leaf springs that a stack moves at flange_a. At flange_b it moves <code>ratio</code> times as far, as behind a lever:
</p>
<p>
s<sub>b</sub> = s<sub>0</sub> + length + ratio x, x = s<sub>a</sub> - s<sub>0</sub><br/>
m d<sup>2</sup>x/dt<sup>2</sup> = f<sub>a</sub> + ratio f<sub>b</sub> - c x - d dx/dt, with d = 2 &#950; &#8730;(c m)
</p>
<p>
The guide presses on the stack with <code>preload</code> as it is mounted. Travels and the flanges' forces count from there, since a constant force
moves nothing in a linear guide; <code>stackForce</code> counts from no force at all. If it falls below 0, the
stack is pulled, which is a warning. By default the guide is as it was mounted where a simulation begins.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end FlexureGuide;
