within IT2Hysteresis.Functions;
function core "One step of the model, within its range and beyond"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Length yPrevious "Displacement at the tick before, y_{k-1}";
  input Modelica.Units.SI.Voltage x "Voltage at this tick, x_k";
  input Real lower[4] "Lower end of the range, of linearisation";
  input Real upper[4] "Upper end of the range, of linearisation";
  output Modelica.Units.SI.Length y "Displacement at this tick, y_k";
algorithm
  if yPrevious < lower[1] then
    y := lower[1] + lower[3]*(x - lower[2]) + lower[4]*(yPrevious - lower[1]);
  elseif yPrevious > upper[1] then
    y := upper[1] + upper[3]*(x - upper[2]) + upper[4]*(yPrevious - upper[1]);
  else
    y := IT2Hysteresis.Functions.step(s1, s2, c, q1, q2, q3, yPrevious, x);
  end if;
  annotation (
    inverse(x=IT2Hysteresis.Functions.coreInverse(s1, s2, c, q1, q2, q3, yPrevious, y, lower, upper)),
    Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.<strong>core</strong>(s1, s2, c, q1, q2, q3, yPrevious, x, lower, upper);
</pre>
<h4>Description</h4>
<p>
For y<sub>k-1</sub> within the range this is <a href=\"modelica://IT2Hysteresis.Functions.step\">step</a>, (10). Beyond an end
y<sub>e</sub> of it the model goes on as its <a href=\"modelica://IT2Hysteresis.Functions.linearisation\">linearisation</a> at the
equilibrium (y<sub>e</sub>, x<sub>e</sub>) there:
</p>
<p>
y<sub>k</sub> = y<sub>e</sub> + A (x<sub>k</sub> - x<sub>e</sub>) + s (y<sub>k-1</sub> - y<sub>e</sub>)
</p>
<p>
(10) itself extrapolates with the memberships of the widest rule, and would diverge. It is affine in x<sub>k</sub> with the
slope A: at y<sub>e</sub> nothing jumps.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end core;
