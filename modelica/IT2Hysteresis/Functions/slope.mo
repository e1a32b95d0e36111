within IT2Hysteresis.Functions;
function slope "dy_k/dx_k of the model"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length yPrevious "Displacement at the tick before, y_{k-1}";
  output Real k(final unit="m/V") "dy_k/dx_k, which does not depend on x_k";
protected
  Real w[size(s1, 1)]=IT2Hysteresis.Functions.memberships(s1, s2, c, yPrevious) "f_l + F_l";
algorithm
  k := q2*w/sum(w);
  annotation (Documentation(info="<html>
<p>(17), summed over the rules. The inverse (30) divides by it: where it is not positive, the model cannot be inverted.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end slope;
