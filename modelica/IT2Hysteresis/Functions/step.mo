within IT2Hysteresis.Functions;
function step "One step of the model, (7), (10)"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Length yPrevious "Displacement at the tick before, y_{k-1}";
  input Modelica.Units.SI.Voltage x "Voltage at this tick, x_k";
  output Modelica.Units.SI.Length y "Displacement at this tick, y_k";
protected
  Real w[size(s1, 1)]=IT2Hysteresis.Functions.memberships(s1, s2, c, yPrevious) "f_l + F_l";
algorithm
  // by scalar products: tools allocate a sum of vectors at every tick
  y := (q1*w*yPrevious + q2*w*x + q3*w)/sum(w);
  annotation (
    inverse(x=IT2Hysteresis.Functions.inverse(s1, s2, c, q1, q2, q3, yPrevious, y)),
    Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.<strong>step</strong>(s1, s2, c, q1, q2, q3, yPrevious, x);
</pre>
<h4>Description</h4>
<p>
y<sub>k</sub> = &#931;<sub>l</sub> (q<sub>l1</sub> y<sub>k-1</sub> + q<sub>l2</sub> x<sub>k</sub> + q<sub>l3</sub>) (f<sub>l</sub> + F<sub>l</sub>)
/ &#931;<sub>l</sub> (f<sub>l</sub> + F<sub>l</sub>) &#160; (10)
</p>
<p>
The <a href=\"modelica://IT2Hysteresis.Functions.memberships\">memberships</a> f<sub>l</sub> + F<sub>l</sub> are those at
y<sub>k-1</sub>. For given y<sub>k-1</sub> the equation is linear in x<sub>k</sub>; its solution
<a href=\"modelica://IT2Hysteresis.Functions.inverse\">inverse</a> is declared as the inverse of this function, so that a tool
solves for x<sub>k</sub> without iteration.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end step;
