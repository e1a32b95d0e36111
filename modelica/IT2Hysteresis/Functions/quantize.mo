within IT2Hysteresis.Functions;
function quantize "Reading of an analogue-to-digital converter"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length x "Value";
  input Modelica.Units.SI.Length xMin "Lower end of the range";
  input Modelica.Units.SI.Length xMax "Upper end of the range";
  input Modelica.Units.SI.Length quantum "Smallest difference of two readings";
  output Modelica.Units.SI.Length y "Reading";
algorithm
  y := xMin + quantum*floor((min(max(x, xMin), xMax) - xMin)/quantum + 0.5);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.<strong>quantize</strong>(x, xMin, xMax, quantum);
</pre>
<h4>Description</h4>
<p>The multiple of <code>quantum</code>, counted from xMin, that is nearest to x within xMin ... xMax.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end quantize;
