within IT2Hysteresis.Functions.Effects;
function saturation "Saturation of the amplifier"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Voltage minimum "Lowest voltage";
  input Modelica.Units.SI.Voltage maximum "Highest voltage";
  input Modelica.Units.SI.Voltage x "Input";
  output Modelica.Units.SI.Voltage y "Output";
algorithm
  y := min(max(x, minimum), maximum);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>saturation</strong>(minimum, maximum, x);
</pre>
<h4>Description</h4>
<p>
y is the voltage nearest to x within the limits. They lose information; the inverse is the same function.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end saturation;
