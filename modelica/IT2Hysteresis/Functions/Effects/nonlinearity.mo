within IT2Hysteresis.Functions.Effects;
function nonlinearity "Static curve between displacement and reading"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length a[3] "Coefficients: quadratic, cubic, quartic";
  input Modelica.Units.SI.Length yMin "Lower end of the curve";
  input Modelica.Units.SI.Length yMax "Upper end of the curve";
  input Modelica.Units.SI.Length y "Displacement";
  output Modelica.Units.SI.Length reading "What is read of it";
protected
  Real z=min(max((y - (yMin + yMax)/2)/((yMax - yMin)/2), -1), 1) "-1 to 1 over the curve";
algorithm
  reading := y + (1 - z^2)*(a[1] + z*(a[2] + z*a[3]));
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
reading = Functions.Effects.<strong>nonlinearity</strong>(a, yMin, yMax, y);
</pre>
<h4>Description</h4>
<p>
reading = y + (1 - z<sup>2</sup>) (a<sub>1</sub> + a<sub>2</sub> z + a<sub>3</sub> z<sup>2</sup>) with z from -1 at yMin to 1 at yMax, and y beyond. It acts on
the reading only, so that the inverse has no part of it.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end nonlinearity;
