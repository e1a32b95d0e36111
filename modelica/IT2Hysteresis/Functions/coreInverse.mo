within IT2Hysteresis.Functions;
function coreInverse "One step of the inverse, within its range and beyond"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Length yPrevious "Displacement at the tick before, y_{k-1}";
  input Modelica.Units.SI.Length y "Desired displacement at this tick, y_k";
  input Real lower[4] "Lower end of the range, of linearisation";
  input Real upper[4] "Upper end of the range, of linearisation";
  output Modelica.Units.SI.Voltage x "Voltage at this tick, x_inv(k)";
algorithm
  if yPrevious < lower[1] then
    x := lower[2] + (y - lower[1] - lower[4]*(yPrevious - lower[1]))/lower[3];
  elseif yPrevious > upper[1] then
    x := upper[2] + (y - upper[1] - upper[4]*(yPrevious - upper[1]))/upper[3];
  else
    x := IT2Hysteresis.Functions.inverse(s1, s2, c, q1, q2, q3, yPrevious, y);
  end if;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.<strong>coreInverse</strong>(s1, s2, c, q1, q2, q3, yPrevious, y, lower, upper);
</pre>
<h4>Description</h4>
<p>
For y<sub>k-1</sub> within the range this is <a href=\"modelica://IT2Hysteresis.Functions.inverse\">inverse</a>, (30). Beyond an
end of it, it undoes what <a href=\"modelica://IT2Hysteresis.Functions.core\">core</a> does there.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end coreInverse;
