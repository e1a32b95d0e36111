within IT2Hysteresis.Functions;
function linearisation "The model at rest at a displacement, and its partial derivatives there"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Length y "Displacement at rest, y_e";
  output Real rest[4] "y_e in m, x_e in V, dy_k/dx_k in m/V and dy_k/dy_{k-1}";
protected
  Real e1[size(s1, 1)] "Exponents of f_l";
  Real e2[size(s1, 1)] "Exponents of F_l";
  Real scale "The largest of them: a common factor of all memberships changes nothing";
  Real w[size(s1, 1)] "f_l + F_l";
  Real v[size(s1, 1)] "Their derivatives by y";
  Modelica.Units.SI.Voltage x "Voltage at rest, x_e";
algorithm
  for l in 1:size(s1, 1) loop
    e1[l] := -(y - c[l])^2/(2*s1[l]^2);
    e2[l] := -(y - c[l])^2/(2*s2[l]^2);
  end for;
  scale := max(max(e1), max(e2));
  for l in 1:size(s1, 1) loop
    w[l] := exp(e1[l] - scale) + exp(e2[l] - scale);
    v[l] := -(y - c[l])*(exp(e1[l] - scale)/s1[l]^2 + exp(e2[l] - scale)/s2[l]^2);
  end for;
  x := (y*sum(w) - (q1*y + q3)*w)/(if abs(q2*w) > 0 then q2*w else 1);
  rest := {y,x,q2*w/sum(w),(q1*w + (q1*y + q2*x + q3 - fill(y, size(s1, 1)))*v)/sum(w)};
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
rest = Functions.<strong>linearisation</strong>(s1, s2, c, q1, q2, q3, y);
</pre>
<h4>Description</h4>
<p>
With n<sub>l</sub> = q<sub>l1</sub> y<sub>e</sub> + q<sub>l2</sub> x<sub>e</sub> + q<sub>l3</sub> and the memberships
w<sub>l</sub> = f<sub>l</sub> + F<sub>l</sub> at y<sub>e</sub>, where x<sub>e</sub> holds the plant at y<sub>e</sub> (30):
</p>
<p>
A = &#8706;y<sub>k</sub>/&#8706;x<sub>k</sub> = &#931;<sub>l</sub> q<sub>l2</sub> w<sub>l</sub> / &#931;<sub>l</sub> w<sub>l</sub><br/>
s = &#8706;y<sub>k</sub>/&#8706;y<sub>k-1</sub> = &#931;<sub>l</sub> (q<sub>l1</sub> w<sub>l</sub> + (n<sub>l</sub> - y<sub>e</sub>) dw<sub>l</sub>/dy) / &#931;<sub>l</sub> w<sub>l</sub>
</p>
<p>
At an end of the range that a parameter set is valid for, s is below 1: the FMUs refuse a set where it is not. So
<a href=\"modelica://IT2Hysteresis.Functions.core\">core</a>, which goes on with A and s beyond the end, is a contraction
there, and no voltage and no start makes a run diverge.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end linearisation;
