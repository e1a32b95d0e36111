within IT2Hysteresis.Functions.Effects;
function resonanceInverse "Inverse of the mechanical resonance"
  extends Modelica.Icons.Function;
  input Real a[4](each unit="1") "Coefficients a1, a2, b0, b1, see resonanceCoefficients";
  input Modelica.Units.SI.Length y1 "Output at the tick before, y_{k-1}";
  input Modelica.Units.SI.Length y2 "Output two ticks before, y_{k-2}";
  input Modelica.Units.SI.Length x1 "Input at the tick before, x_{k-1}";
  input Modelica.Units.SI.Length y "Output at this tick, y_k";
  output Modelica.Units.SI.Length x "Input at this tick, x_k";
algorithm
  x := (y - a[1]*y1 - a[2]*y2 - a[4]*x1)/a[3];
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.Effects.<strong>resonanceInverse</strong>(a, y1, y2, x1, y);
</pre>
<h4>Description</h4>
<p>
x<sub>k</sub> = (y<sub>k</sub> - a<sub>1</sub> y<sub>k-1</sub> - a<sub>2</sub> y<sub>k-2</sub> - b<sub>1</sub> x<sub>k-1</sub>) / b<sub>0</sub>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end resonanceInverse;
