within IT2Hysteresis.Functions.Effects;
function nonlinearity "Static curve of the stack or of the sensor"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length a[5] "Coefficients: quadratic, cubic, quartic, quintic, sextic";
  input Modelica.Units.SI.Length yMin "Lower end of the curve";
  input Modelica.Units.SI.Length yMax "Upper end of the curve";
  input Modelica.Units.SI.Length x "Displacement without the curve";
  output Modelica.Units.SI.Length y "Displacement";
protected
  Real z=(x - (yMin + yMax)/2)/((yMax - yMin)/2) "-1 to 1 over the curve";
  Real nearest=min(max(z, -1), 1) "The place on the curve that is nearest";
  Modelica.Units.SI.Length polynomial=a[1] + nearest*(a[2] + nearest*(a[3] + nearest*(a[4] + nearest*a[5])));
algorithm
  y := x + (1 - nearest^2)*polynomial - 2*nearest*polynomial*(z - nearest);
  annotation (
    inverse(x=IT2Hysteresis.Functions.Effects.nonlinearityInverse(a, yMin, yMax, y)),
    Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>nonlinearity</strong>(a, yMin, yMax, x);
</pre>
<h4>Description</h4>
<p>
y = x + (1 - z<sup>2</sup>) (a<sub>1</sub> + a<sub>2</sub> z + ... + a<sub>5</sub> z<sup>4</sup>) with z from -1 at yMin to 1 at yMax, and beyond with its slope there. A
parameter set whose curve does not rise from end to end is refused by the FMUs.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end nonlinearity;
