within IT2Hysteresis.Components;
model StrainGauge "Sampled displacement sensor with noise and quantisation"
  replaceable record Stage = IT2Hysteresis.Parameters.Table1
    constrainedby IT2Hysteresis.Parameters.Base "Parameter set"
    annotation (choicesAllMatching=true);
  parameter Stage parameters "Parameter set of the actuator, which gives the sample time";
  parameter Modelica.Units.SI.Time sampleTime(min=1e-9, max=1e3, displayUnit="ms")=parameters.sampleTime
    "Sample time";
  parameter Modelica.Units.SI.Length offset(min=-10, max=10)=18e-3
    "Distance of the flanges that is read as 0";
  parameter Modelica.Units.SI.Length yMin(min=-0.1, max=0.1, displayUnit="um")=0
    "Lower end of the range";
  parameter Modelica.Units.SI.Length yMax(min=-0.1, max=0.1, displayUnit="um")=16e-6
    "Upper end of the range";
  parameter Integer bits(min=1, max=32)=16 "Bits of the converter";
  parameter Modelica.Units.SI.Length sigma(min=0, max=0.1, displayUnit="um")=5e-9
    "Standard deviation of the noise, before quantisation";
  parameter Integer seed(min=1, max=2147483647)=614657 "Seed of the noise: two gauges differ in it";
  Modelica.Mechanics.Translational.Interfaces.Flange_a flange_a "Flange that the displacement counts from"
    annotation (Placement(transformation(extent={{-110,-10},{-90,10}})));
  Modelica.Mechanics.Translational.Interfaces.Flange_b flange_b "Flange that moves"
    annotation (Placement(transformation(extent={{90,-10},{110,10}})));
  Modelica.Blocks.Interfaces.RealOutput y(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5,
    start=yMin,
    fixed=true) "Reading, held from one tick to the next"
    annotation (Placement(transformation(
      extent={{-10,-10},{10,10}},
      rotation=270,
      origin={0,-110})));
protected
  final parameter Modelica.Units.SI.Length quantum=(yMax - yMin)/(2^bits - 1)
    "Smallest difference of two readings";
  final parameter Integer firstState[2]=
    Modelica.Math.Random.Generators.Xorshift64star.initialState(seed, 30020)
    "Of the random number generator";
  discrete Real uniform(start=0.5, fixed=true) "Random number between 0 and 1";
  discrete Integer state[2](
    start=firstState,
    each fixed=true) "State of the random number generator";
algorithm
  when sample(0, sampleTime) then
    (uniform,state) := Modelica.Math.Random.Generators.Xorshift64star.random(pre(state));
    y := IT2Hysteresis.Functions.quantize(
      flange_b.s - flange_a.s - offset
        + Modelica.Math.Distributions.Normal.quantile(uniform, 0, sigma),
      yMin,
      yMax,
      quantum);
  end when;
equation
  flange_a.f = 0;
  flange_b.f = 0;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-90,40},{90,-40}},
          lineColor={0,0,0},
          fillColor={245,245,245},
          fillPattern=FillPattern.Solid),
        Line(points={{-90,0},{-60,0},{-60,24},{-45,24},{-45,-24},{-30,-24},{-30,24},{-15,24},{-15,-24},{0,-24},{0,24},{15,24},{15,-24},{30,-24},{30,24},{45,24},{45,-24},{60,-24},{60,0},{90,0}}, color={162,29,33}),
        Line(points={{0,-100},{0,-40}}, color={0,0,127}),
        Text(
          extent={{10,-50},{150,-80}},
          textString="%bits bits"),
        Text(
          extent={{-150,90},{150,50}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>
At every tick the distance of the flanges, less <code>offset</code>, is read: with normally distributed noise, within
<code>yMin</code> ... <code>yMax</code>, in steps of <code>quantum</code> = (yMax - yMin)/(2<sup>bits</sup> - 1). The reading is held until the next tick.
By default <code>offset</code> is the length of the default <a href=\"modelica://IT2Hysteresis.Components.PiezoActuator\">actuator</a>.
Hand the gauge the actuator's parameter set: it reads at its sample time. It takes no force. The noise is the same in every run with the same <code>seed</code>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end StrainGauge;
