within IT2Hysteresis.Components;
block SampledPI "Sampled PI controller beside a feedforward"
  replaceable record Stage = IT2Hysteresis.Parameters.Table1
    constrainedby IT2Hysteresis.Parameters.Base "Parameter set"
    annotation (choicesAllMatching=true);
  parameter Stage parameters "Parameter set of the actuator, which gives the sample time";
  parameter Modelica.Units.SI.Time sampleTime(min=1e-9, max=1e3, displayUnit="ms")=parameters.sampleTime
    "Sample time";
  parameter Real k(unit="V/m", min=0, max=1e12)=2e6 "Gain";
  parameter Modelica.Units.SI.Time Ti(min=1e-9, max=1e6, displayUnit="ms")=1e-3 "Integration time";
  parameter Modelica.Units.SI.Voltage yMax(min=0, max=2000)=50
    "Largest correction, of either sign";
  Modelica.Blocks.Interfaces.RealInput reference(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5) "Desired displacement"
    annotation (Placement(transformation(extent={{-140,40},{-100,80}})));
  Modelica.Blocks.Interfaces.RealInput measured(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5) "Displacement as it is measured"
    annotation (Placement(transformation(extent={{-140,-80},{-100,-40}})));
  Modelica.Blocks.Interfaces.RealOutput y(
    final quantity="ElectricPotential",
    final unit="V",
    nominal=10,
    start=0,
    fixed=true) "Correction of the voltage"
    annotation (Placement(transformation(extent={{100,-10},{120,10}})));
protected
  discrete Modelica.Units.SI.Length wanted(start=0, fixed=true) "Reference at this tick";
  discrete Modelica.Units.SI.Length seen(start=0, fixed=true) "Displacement at this tick";
  discrete Modelica.Units.SI.Length error(start=0, fixed=true) "Error at the tick before";
  discrete Modelica.Units.SI.Voltage integral(start=0, fixed=true) "Integral part";
equation
  when sample(0, sampleTime) then
    wanted = reference;
    seen = measured;
    error = pre(wanted) - pre(seen);
    integral = min(max(pre(integral) + k*sampleTime/Ti*error, -yMax), yMax);
    y = min(max(k*error + integral, -yMax), yMax);
  end when;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-100,100},{100,-100}},
          lineColor={0,0,127},
          fillColor={255,255,255},
          fillPattern=FillPattern.Solid),
        Line(points={{-70,-70},{-70,-10},{60,60}}, color={0,0,127}),
        Line(points={{-80,-70},{80,-70}}, color={192,192,192}),
        Text(
          extent={{0,-10},{80,-60}},
          textString="PI",
          textColor={192,192,192}),
        Text(
          extent={{-150,-110},{150,-140}},
          textString="k=%k"),
        Text(
          extent={{-150,150},{150,110}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>
At tick k the controller knows the displacement that the tick before has led to, as a computer with a converter does:
</p>
<p>
e<sub>k</sub> = reference<sub>k-1</sub> - measured<sub>k-1</sub><br/>
y<sub>k</sub> = k e<sub>k</sub> + I<sub>k</sub>, I<sub>k</sub> = I<sub>k-1</sub> + k T<sub>s</sub>/T<sub>i</sub> e<sub>k</sub>
</p>
<p>
Hand it the plant's parameter set, so that it ticks with the plant. Then there is no algebraic loop. An exact feedforward leaves e at 0: the
controller corrects only what the model does not know. Output and integral are kept within <code>yMax</code>, so that the integral
does not wind up.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end SampledPI;
