within IT2Hysteresis.Functions;
function inverse "One step of the inverse, (30)"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Length yPrevious "Displacement at the tick before, y_{k-1}";
  input Modelica.Units.SI.Length y "Desired displacement at this tick, y_k";
  output Modelica.Units.SI.Voltage x "Voltage at this tick, x_inv(k)";
protected
  Real w[size(s1, 1)]=IT2Hysteresis.Functions.memberships(s1, s2, c, yPrevious) "f_l + F_l";
algorithm
  x := (y*sum(w) - q1*w*yPrevious - q3*w)/(if abs(q2*w) > 0 then q2*w else 1);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.<strong>inverse</strong>(s1, s2, c, q1, q2, q3, yPrevious, y);
</pre>
<h4>Description</h4>
<p>
x<sub>k</sub> = (y<sub>k</sub> &#931;<sub>l</sub> (f<sub>l</sub> + F<sub>l</sub>) - &#931;<sub>l</sub> (q<sub>l1</sub> y<sub>k-1</sub> + q<sub>l3</sub>) (f<sub>l</sub> + F<sub>l</sub>))
/ &#931;<sub>l</sub> q<sub>l2</sub> (f<sub>l</sub> + F<sub>l</sub>) &#160; (30)
</p>
<p>
The <a href=\"modelica://IT2Hysteresis.Functions.memberships\">memberships</a> f<sub>l</sub> + F<sub>l</sub> are those at the
desired y<sub>k-1</sub>. With y<sub>k</sub> = y<sub>k-1</sub> the result is the voltage that holds the plant where it is.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end inverse;
