within IT2Hysteresis.Functions.Effects;
function nonlinearityInverse "Inverse of the static curve"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length a[5] "Coefficients: quadratic, cubic, quartic, quintic, sextic";
  input Modelica.Units.SI.Length yMin "Lower end of the curve";
  input Modelica.Units.SI.Length yMax "Upper end of the curve";
  input Modelica.Units.SI.Length y "Displacement";
  output Modelica.Units.SI.Length x "Displacement without the curve";
protected
  constant Integer halvings=54 "Of the interval -1 to 1, to the last digit of z";
  Real aim=(y - (yMin + yMax)/2)/((yMax - yMin)/2) "y, -1 to 1 over the curve";
  Real nearest=min(max(aim, -1), 1) "The place on the curve that is nearest";
  Modelica.Units.SI.Length polynomial=a[1] + nearest*(a[2] + nearest*(a[3] + nearest*(a[4] + nearest*a[5])));
  Real low=-1 "The z that is sought is not below";
  Real high=1 "It is not above";
  Real z "x, -1 to 1 over the curve";
algorithm
  for i in 1:halvings loop
    z := (low + high)/2;
    if z + (1 - z^2)*(a[1] + z*(a[2] + z*(a[3] + z*(a[4] + z*a[5]))))/((yMax - yMin)/2) > aim then
      high := z;
    else
      low := z;
    end if;
  end for;
  z := if aim > -1 and aim < 1 then (low + high)/2 else nearest + (aim - nearest)/(1 - 2*nearest*polynomial/((
    yMax - yMin)/2));
  x := (yMin + yMax)/2 + z*((yMax - yMin)/2);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.Effects.<strong>nonlinearityInverse</strong>(a, yMin, yMax, y);
</pre>
<h4>Description</h4>
<p>
The curve rises from yMin to yMax, so that the interval that holds x can be halved until nothing is left of it. Beyond the
ends the slope that the curve has there goes on.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end nonlinearityInverse;
