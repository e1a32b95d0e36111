within IT2Hysteresis.Functions.Effects;
function resonance "Mechanical resonance"
  extends Modelica.Icons.Function;
  input Real a[2](each unit="1") "Coefficients a1, a2, see resonancePoles";
  input Modelica.Units.SI.Length y1 "Output at the tick before, y_{k-1}";
  input Modelica.Units.SI.Length y2 "Output two ticks before, y_{k-2}";
  input Modelica.Units.SI.Length x "Input at this tick, x_k";
  output Modelica.Units.SI.Length y "Output at this tick, y_k";
algorithm
  y := a[1]*y1 + a[2]*y2 + (1 - a[1] - a[2])*x;
  annotation (
    inverse(x=IT2Hysteresis.Functions.Effects.resonanceInverse(a, y1, y2, y)),
    Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>resonance</strong>(a, y1, y2, x);
</pre>
<h4>Description</h4>
<p>
y<sub>k</sub> = a<sub>1</sub> y<sub>k-1</sub> + a<sub>2</sub> y<sub>k-2</sub> + (1 - a<sub>1</sub> - a<sub>2</sub>) x<sub>k</sub>: exact poles and no zeros, so
that the inverse does not oscillate.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end resonance;
